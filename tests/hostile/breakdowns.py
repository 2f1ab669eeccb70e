"""Loops, crashes, memory, depth and floods: a failing answer is lost, right answers count."""

from dataclasses import replace

from hostile.case import COUNTED, EVERYTHING, SANDBOXED, Case

LOST = ("01.2",)
WROTE = "it wrote too much"


def fit(body, name, **more):
    """A case in which only `fit` is lost; `body` is its code."""
    code = "def fit(points, values):\n" + "\n".join("    " + line for line in body.split("\n"))
    return Case(name, lost=LOST, answers={"fit": code}, **more)


def cell(code, name, **more):
    """A case in which nothing is lost; a cell at the end fails."""
    return Case(name, after=code, **more)


LOOPS = [
    fit("while True: pass", "a loop in an answer"),
    cell("while True: pass", "a loop in a cell", status="killed: time"),
    fit(
        """import time
while True:
    try:
        time.sleep(9)
    except BaseException:
        continue""",
        "a loop that swallows every exception",
        status="killed: time",
    ),
    fit(
        """import signal
signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 64))
for number in (1, 2, 3, 13, 14, 15, 24):
    signal.signal(number, signal.SIG_IGN)
while True: pass""",
        "a loop deaf to signals",
        status="killed: time",
    ),
    fit("import re\nre.match(r'(a+)+$', 'a' * 64 + 'b')", "a regular expression without an end"),
    fit("return 7 ** (10 ** 9)", "a power of many digits"),
    fit("import time\nwhile True:\n    time.sleep(3600)", "a sleep"),
    fit("import threading\nlock = threading.Lock()\nlock.acquire()\nlock.acquire()", "a deadlock"),
    fit("import itertools\nreturn sum(itertools.repeat(1.0))", "an endless sum in C"),
    cell(
        """
class Slow:
    def __del__(self):
        while True: pass
slow = Slow(); del slow
""",
        "a loop while an object is let go of",
    ),
    cell(
        """
import threading
for _ in range(4):
    threading.Thread(target=lambda: [None for _ in iter(int, 1)], daemon=True).start()
""",
        "busy threads in the background",
    ),
    fit(
        "class Slow(float):\n    def __float__(self):\n        while True: pass\n"
        "    def __array__(self, *args, **kwargs):\n        while True: pass\n"
        "return [Slow(1), 'x']",
        "a loop that begins when the answer is read",
    ),
    fit(
        """import signal
signal.setitimer(signal.ITIMER_REAL, 0)
signal.setitimer = signal.signal = lambda *args: None
while True: pass""",
        "a loop without its alarm",
        status="killed: time",
    ),
]

CRASHES = [
    fit("import ctypes\nctypes.string_at(0)", "a segmentation fault", status="partly"),
    cell("import ctypes; ctypes.string_at(0)", "a segmentation fault in a cell", status="partly"),
    fit("import os\nos.abort()", "an abort", status="partly"),
    fit("import os\nos._exit(0)", "an exit that says all is well", status="partly"),
    cell("import os; os._exit(0)", "an exit in a cell"),
    fit("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)", "suicide"),
    fit(
        "import signal\nsignal.raise_signal(signal.SIGKILL)",
        "suicide that looks like a lack of memory",
        status="graded",
        tiers=SANDBOXED,
    ),
    fit(
        """import resource
resource.setrlimit(resource.RLIMIT_CPU, (0, 1))
while True: pass""",
        "a limit lowered so that the system kills",
        status="graded",
        tiers=SANDBOXED,
    ),
    fit(
        """import ctypes
class Event(ctypes.Structure):
    _fields_ = [("value", ctypes.c_long), ("signal", ctypes.c_int), ("rest", ctypes.c_int * 13)]
number = {"x86_64": 222, "aarch64": 107}[__import__("os").uname().machine]
timer, c = ctypes.c_int(), ctypes.CDLL(None)
if c.syscall(number, 1, ctypes.byref(Event(0, 9)), ctypes.byref(timer)) == -1:
    raise OSError
times = (ctypes.c_long * 4)(0, 0, 0, 10 ** 6)
c.syscall(number + (1 if number == 222 else 3), timer, 0, times, None)
import time; time.sleep(3)""",
        "a timer that kills",
        status="graded",
        tiers=SANDBOXED,
    ),
    fit("import sys\nsys.exit(0)", "sys.exit in an answer", status="graded"),
    fit("raise KeyboardInterrupt", "an interrupt raised by an answer"),
    fit(
        "class Odd(BaseException):\n    def __str__(self): raise self\nraise Odd",
        "an exception that cannot be shown",
    ),
    fit("import faulthandler\nfaulthandler._sigsegv()", "a segmentation fault by Python's own"),
    fit(
        "import resource\nresource.setrlimit(resource.RLIMIT_AS, (1, 1))\nreturn [0.0] * 10**7",
        "limits lowered to nothing",
    ),
    cell(
        "import os\nfor number in range(3, 64):\n    try: os.close(number)\n"
        "    except OSError: pass",
        "every file closed",
    ),
    Case("all modules gone", after="import sys; sys.modules.clear()", lost=EVERYTHING),
    cell(
        "import builtins\nfor name in list(vars(builtins)):\n    if name != 'delattr': "
        "delattr(builtins, name)",
        "no built-in functions",
        status="partly",
    ),
]

MEMORY = [
    fit("kept = []\nwhile True:\n    kept.append(bytearray(1 << 24))", "memory without an end"),
    fit("return np.ones(10 ** 11)", "an array beyond all memory", status="graded"),
    cell("kept = bytearray(1 << 40)", "too much memory in a cell", status="graded"),
    fit("text = 'x'\nwhile True:\n    text += text", "a string that doubles"),
    fit("return fit(points, values)", "recursion without an end", status="graded"),
    fit(
        "import sys\nsys.setrecursionlimit(10 ** 9)\n"
        "class Deep:\n    def __repr__(self): return repr(self)\nrepr(Deep())\nfit(points, values)",
        "recursion without a limit",
    ),
    fit(
        "kept = ()\nfor _ in range(10 ** 6):\n    kept = (kept,)\nreturn kept",
        "tuples in tuples, a million deep",
    ),
    fit(
        "import threading, time\n"
        "while True:\n    threading.Thread(target=time.sleep, args=(60,), daemon=True).start()",
        "threads without an end",
    ),
    fit(
        "import mmap\nkept = []\nwhile True:\n    kept.append(mmap.mmap(-1, 1 << 26))\n"
        "    kept[-1].write(b'x' * (1 << 26))",
        "memory shared with nobody",
    ),
]

FLOODS = [
    cell("for _ in range(200): print('x' * 1_000_000)", "200 MB printed", status="graded"),
    cell(
        "import sys\nfor _ in range(100): sys.stderr.write('x' * 1_000_000)",
        "100 MB of warnings",
        status="graded",
    ),
    fit(
        "import os\nwhile True:\n    os.write(1, b'x' * 65536); os.write(2, b'x' * 65536)",
        "output without an end",
    ),
    fit("raise ValueError('x' * 50_000_000)", "an error of 50 MB", status="graded"),
    fit("return np.zeros((3000, 3000))", "an array larger than can be returned", status="graded"),
    fit("return np.zeros((1,) * 20)", "an array of too many axes"),
    fit("return tuple(np.zeros(1) for _ in range(1000))", "too many arrays", status="graded"),
    fit("return np.zeros((5, 0, 7))", "an array of nothing", status="graded"),
    fit(
        "file = open('large', 'wb')\nwhile True:\n    file.write(b'x' * (1 << 20))",
        "a file without an end",
    ),
    *(
        cell(
            f"""
import ctypes, mmap, os, struct, time
c, kept, written = ctypes.CDLL(None), [], 0
{before}
for k in range(40):
    with open("f", "w+b") as file:
        try:
            file.write(bytes(16 << 20)); file.flush()
        except OSError:
            break
        {keep}
    os.unlink("f")
    written += 16
time.sleep(2)
raise ValueError(f"{{written}} MiB are kept")
""",
            name,
            notes=notes,
            tiers=SANDBOXED,
        )
        for name, before, keep, notes in (
            (
                "files without a name",
                "",
                "kept.append(os.open('.', os.O_TMPFILE | os.O_RDWR)); "
                "os.write(kept[-1], bytes(15 << 20))",
                WROTE,
            ),
            (
                "files that are allocated and not written",
                "",
                "kept.append(open(f'{k}', 'wb')); "
                "os.posix_fallocate(kept[-1].fileno(), 0, 15 << 20)",
                WROTE,
            ),
            ("deleted files, kept open", "", "kept.append(os.dup(file.fileno()))", WROTE),
            (
                "deleted files, kept mapped",
                "c.mmap.argtypes = [ctypes.c_long] * 6",
                "c.mmap(0, 4096, mmap.PROT_READ, mmap.MAP_SHARED, file.fileno(), 0)",
                WROTE,
            ),
            (
                "deleted files, kept by rules of access",
                'rules = c.syscall(444, struct.pack("Q", 4), 8, 0)',
                'assert not c.syscall(445, rules, 1, struct.pack("=Qi", 4, file.fileno()), 0)',
                "AssertionError",
            ),
        )
    ),
    fit(
        "import time\nfor k in range(10 ** 6):\n    open(f'file{k}', 'w').close()\ntime.sleep(60)",
        "files without an end",
    ),
    fit(
        "for k in range(1500):\n    open(f'file{k}', 'w').close()\nreturn np.zeros(3)",
        "more files than allowed, written before anybody looks",
    ),
    cell(
        "for k in range(1500):\n    open(f'file{k}', 'w').close()",
        "more files than allowed, in a cell",
        status="partly",
    ),
    fit(
        "import os\nfor _ in range(3000):\n    os.mkdir('d' * 100); os.chdir('d' * 100)\n"
        "import time; time.sleep(60)",
        "folders in folders",
        tiers=SANDBOXED,
    ),
    fit(
        "import os\nos.mkdir('closed'); open('closed/x', 'w').close(); os.chmod('closed', 0)\n"
        "os.symlink('@CANARY@', 'link'); os.symlink('/', 'root'); os.mkfifo('pipe')",
        "a folder that is closed, and links",
    ),
]

MEMORY = [replace(case, tiers=COUNTED) for case in MEMORY]
CASES = [*LOOPS, *CRASHES, *MEMORY, *FLOODS]
