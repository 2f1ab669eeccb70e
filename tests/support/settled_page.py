"""A page of the site whose script has seen the sizes of everything on it."""

TWO_FRAMES = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""The observers of sizes act in the first frame, which may come after the page is loaded."""


def settled_page(context, path):
    """Open a file in a page of the context, and wait for the second frame."""
    page = context.new_page()
    page.goto(path.as_uri())
    page.evaluate(TWO_FRAMES)
    return page
