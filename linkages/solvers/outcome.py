"""How an integration ended, as sentences with a remedy."""

from __future__ import annotations

from enum import IntEnum


class Outcome(IntEnum):
    """How an integration ended.

    The values are what the compiled loops return. Every member carries a `sentence` that says
    what happened and a `remedy` that says what to do about it.
    """

    sentence: str
    remedy: str

    DONE = 0, "The integration reached its end.", ""
    UNREACHABLE = (
        1,
        "The links of a block no longer reach each other: the position cannot be assembled.",
        "Check lengths, drives and the initial state, or end the simulation before this time.",
    )
    SINGULAR = (
        2,
        "The two links of a block are aligned: the mechanism may go on in either assembly mode.",
        "Change a length or an initial state so that the links pass beside this position, "
        "or end the simulation before this time.",
    )
    STEP_TOO_SMALL = (
        3,
        "The step fell below the resolution of time before the tolerance was met.",
        "Look for a force that grows without bound near this time; a loose tolerance can lead to "
        "such places, and a very tight one can ask for more than round-off allows.",
    )
    NOT_FINITE = (
        4,
        "The motion diverged: a state or an acceleration is no longer a finite number.",
        "Take a smaller step, or an adaptive method.",
    )
    STEP_BUDGET = (
        5,
        "The allowed number of steps was used up before the end.",
        "Raise max_steps, loosen the tolerance, or simulate a shorter time.",
    )
    INTERRUPTED = (
        6,
        "The integration was interrupted.",
        "What was computed so far is kept.",
    )

    NOT_CONVERGED = (
        7,
        "The equations of an implicit step could not be solved: its stages did not settle.",
        "Take a smaller step: the iteration converges if accelerations change little within one.",
    )
    EVENT = (
        8,
        "The integration ended at an event, as asked for.",
        "Start again from the final state to go on.",
    )

    SLIDING = (
        9,
        "A mode has no value: on both sides of the zero of its function the motion is pushed back "
        "onto it, as friction that jumps holds a body at rest.",
        "Take a force times sign(…), on whose zero the motion may stay, or a law without a jump, "
        "such as tanh(v/v0) for friction.",
    )
    CHATTER = (
        10,
        "A mode changes again and again while time hardly goes on, as where a ball comes to rest "
        "by ever smaller impacts.",
        "End before this time, or take a law that lets this end.",
    )

    def __new__(cls, value: int, sentence: str = "", remedy: str = "") -> Outcome:
        """Make a member from its value and its two sentences."""
        member = int.__new__(cls, value)
        member._value_ = value
        member.sentence = sentence
        member.remedy = remedy
        return member

    def __str__(self) -> str:
        return f"{self.sentence} {self.remedy}".strip()
