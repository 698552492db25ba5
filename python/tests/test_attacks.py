"""Attacks that the Rust tests have written to the file AGHF_ATTACKS_FILE, one JSON list of four texts per line: each
breaks a promise by a dense evaluation, so the checker must refuse it."""

import json
import os

import pytest
from aghf import check_certificate

STEP = 40  # a check takes a twentieth of a second


@pytest.mark.skipif("AGHF_ATTACKS_FILE" not in os.environ, reason="no attacks are given")
def test_motions_that_break_a_promise_are_refused():
    tried = 0
    with open(os.environ["AGHF_ATTACKS_FILE"], encoding="utf-8") as file:
        for i, line in enumerate(file):
            if i % STEP == 0:
                with pytest.raises(check_certificate.Refused):
                    check_certificate.check(*json.loads(line))
                tried += 1
    assert tried > 0
