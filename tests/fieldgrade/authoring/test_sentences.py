"""Sentences for students are short enough to be read once."""

import re

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.answers import Answers, public_answers
from fieldcheck.calls import Outcome
from fieldcheck.judge import judge
from fieldcheck.questions import questions
from fieldcheck.seeds import EVERYBODY, seed
from fieldgrade.authoring import build
from fieldgrade.authoring.catalogue import entries
from fieldgrade.authoring.hidden_cases import hidden_cases

MOST_WORDS = 30
MOST_WORDS_OF_A_CASE = 15
"""Such as "ten points", in "For ten points, entry [0] is off by 1"."""

SOURCES = build.all_sources(ROOT)
QUESTIONS = questions().values()


def long_sentences(text):
    """The sentences with too many words; a formula between spaces is a word."""
    return [s for s in re.split(r"(?<=[.?!]) ", text) if len(s.split()) > MOST_WORDS]


def laws():
    return [law.sentence for question in QUESTIONS for law in question.laws]


def mistakes():
    return [entry.sentence for source in SOURCES for entry in entries(source, "misconceptions")]


def hidden_sentences():
    return [case.sentence for source in SOURCES for case in hidden_cases(source)]


def verdicts():
    """The verdicts on values that are not finite, and on multiples of the right ones.

    Another multiple in each case gives the longest sentences. No mistakes are recognized.
    """
    sentences = []
    for question in QUESTIONS:
        calls = question.inputs(seed(EVERYBODY, question.name))
        right = public_answers(question.notebook)[question.name].right
        for factors in ([np.nan] * len(calls), range(2, len(calls) + 2)):
            outcomes = [
                Outcome("returned", values=tuple(k * v for v in values))
                for k, values in zip(factors, right, strict=True)
            ]
            sentences.append(judge(question, calls, outcomes, Answers(right, ())).sentence)
    return sentences


@pytest.mark.slow
@pytest.mark.parametrize("sentences", [laws, mistakes, hidden_sentences, verdicts])
def test_no_sentence_has_more_than_thirty_words(sentences):
    texts = sentences()
    assert len(texts) > 50
    assert not [long for text in texts for long in long_sentences(text)]


@pytest.mark.slow
def test_no_name_of_a_case_is_long():
    """Each name of a case stands in a sentence of the verdict."""
    public = [call.case for question in QUESTIONS for call in question.inputs(0)]
    hidden = [c.case for s in SOURCES for h in hidden_cases(s) for c in h.inputs(0)]
    names = public + hidden
    assert not [name for name in names if len(name.split()) > MOST_WORDS_OF_A_CASE]
