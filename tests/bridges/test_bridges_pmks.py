"""Share links of PMKS+.

The links are those of its templates, from the file template-linkages.ts of
https://github.com/PMKS-Web/PMKSWeb.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import linkages

SITE = "https://app.pmksplus.com/?"
FOUR_BAR = (
    "2P.Ay,1E8.K,0.1011.MA,A,0mv,0VU,0.GB,B,0e_,E6,0.GC,C,l1,WW,0.KD,D,qD,0Pk,0."
    ".YRAB,AB,Fe,Fe,0ix,08i,c5cae9,A,B,,.YRBC,BC,Fe,Fe,32,NJ,303e9f,B,C,,"
    ".YRCD,CD,Fe,Fe,nd,3P,0d125a,C,D,,...N_v"
)
WHITWORTH = (
    "2P.Ay,1E8.K,0.1011.MA,A,0,0,0.GB,B,0,ku,0.KC,C,Fe,0,0.GD,D,095,1A7,0.HP,P,0,ku,0,CD,C,D."
    ".YRAB,AB,Fe,Fe,0,NS,c5cae9,A,B,,.YRCD,CD,Fe,Fe,3H,b4,303e9f,C,D,,.YPBP,BP,Fe,0,0,0,,B,P,,...N_w"
)
PUNCH_PRESS = (
    "2P.Ay,1E8.K,0.1011.MA,A,0,0,0.GB,B,0,Im,0.GC,C,0,0r8,0.LP,P,0,0r8,OZ."
    ".YRAB,Crank,VG,o,0,9O,c5cae9,A,B,,.YRBC,Connecting rod,ku,6G,0,0HC,303e9f,B,C,,"
    ".YPCP,CP,1Tm,0,0,0,,C,P,,..2F1,BC,F1,0,0r8,0,0bW,1Xg0..N_J"
)
JANSEN = (
    "2P.1jO,1E8.K,0.1011.MO,O,0,0,0.GA,A,3gO,0,0.KG,G,09Hm,01vu,0.GB,B,05tE,7ee,0.GC,C,0IGg,1-F,0."
    "GD,D,06b8,0B7B,0.GE,E,0ETW,06sL,0.GF,F,0AYO,0MPj,0..YROA,OA,Fe,Fe,1rC,0,c5cae9,O,A,,"
    ".YRAB,AB,Fe,Fe,016R,3qK,303e9f,A,B,,.YRGBC,GBC,Fe,Fe,0B8Z,2ag,0d125a,G,B,C,,"
    ".YRAD,AD,Fe,Fe,01TO,05Zc,B2DFDB,A,D,,.YRGD,GD,Fe,Fe,07xS,06WY,26A69A,G,D,,"
    ".YRCE,CE,Fe,Fe,0GN5,02RZ,00695C,C,E,,.YRDEF,DEF,Fe,Fe,0AXh,0DT4,c5cae9,D,E,F,,...N_c"
)
BOOM = (
    "2P.Ay,Fe.K,0.1011.KO,O,0,0,0.GC,C,0,_W,0.KG,G,ku,0,0.GN,N,Ju,Z-,0.OP,P,R0,QX,0."
    "pS,S,R0,QX,0,GN,G,N..YROC,OC,Fe,Fe,0,VG,c5cae9,O,C,,.YRGN,GN,Fe,Fe,XO,I0,303e9f,G,N,,"
    ".YRPC,PC,Fe,Fe,DW,iW,0d125a,P,C,,.YPPS,PS,Fe,0,0,0,,P,S,,...N_e"
)


def checked(body):
    """A link with the character that says how long it is."""
    return body + "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"[len(body) % 62]


def at_start(mechanism):
    data = linkages.simulate(mechanism, end=0.1, samples=11).data
    return {str(n): data.joint_position.sel(joint=n).to_numpy()[0] for n in data.joint.to_numpy()}


def test_a_four_bar_by_hand():
    """Numbers decoded by hand: 'e_' is 40·64 + 62 = 2622 thousandths of a centimetre, and so on."""
    mechanism = linkages.from_pmks(SITE + FOUR_BAR)
    places = at_start(mechanism)
    wanted = {"A": (-3.129, -2.014), "B": (-2.622, 0.902), "C": (3.009, 2.08), "D": (3.341, -1.646)}
    for name, place in wanted.items():
        assert places[name] == pytest.approx(np.array(place) / 100, abs=1e-15)
    lengths = {b.name: b.length for b in mechanism.components if b.section == "bars"}
    assert lengths["BC"] == pytest.approx(math.hypot(5.631, 1.178) / 100, rel=1e-14)
    (drive,) = (part for part in mechanism.components if part.section == "drives")
    # 20 rpm, clockwise
    assert (drive.name, drive.speed) == ("AB", pytest.approx(-20 * 2 * math.pi / 60))


@pytest.mark.parametrize("link", [FOUR_BAR, WHITWORTH, PUNCH_PRESS, JANSEN])
def test_templates_are_assembled_where_they_were_drawn(link):
    mechanism = linkages.from_pmks(link)
    places = at_start(mechanism)
    # records of joints: flags and id, name, x, y, angle
    records = [r.split(",") for r in link.split("..")[0].split(".")[4:]]
    digits = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-"

    def number(text):
        value = sum(digits.index(c) * 64**k for k, c in enumerate(reversed(text)))
        return (-value if text[0] == "0" and len(text) > 1 else value) / 1000

    drawn = {r[1]: (number(r[2]), number(r[3])) for r in records if r[0][0] not in "LH"}
    for name, place in drawn.items():
        # Jansen's leg was drawn to thousandths, in which its eight bars close
        assert places[name] == pytest.approx(np.array(place) / 100, abs=2e-9)
    assert linkages.simulate(mechanism, end=3.0, samples=61).completed  # a turn


def test_a_guide_on_a_link_and_a_force():
    quick = linkages.from_pmks(WHITWORTH)
    (slider,) = (part for part in quick.components if part.section == "sliders")
    assert (slider.joint, slider.on, slider.through) == ("B", "CD", "C")
    press = linkages.from_pmks(PUNCH_PRESS)
    (load,) = (part for part in press.components if part.section == "loads")
    # from C upwards, 400 N
    assert load.joint == "C"
    assert [float(part) for part in load.force] == pytest.approx([0.0, 400.0])
    masses = {p.name: p.mass for p in press.components if p.section in ("bars", "sliders")}
    assert masses == pytest.approx({"Crank": 2e-3, "Connecting rod": 3e-3, "slider C": 6e-3})
    light = linkages.from_pmks(PUNCH_PRESS, masses=False)
    assert not any(getattr(part, "mass", 0.0) for part in light.components)


@pytest.mark.parametrize(
    ("link", "message"),
    [
        ("https://app.pmksplus.com/", "expected a share link of PMKS"),
        (FOUR_BAR[:-5] + "_v", "the link is not whole"),
        (checked(FOUR_BAR[:-1].replace("MA,A,0mv", "MA,0mv")), "a record of the link is not"),
        (checked(FOUR_BAR[:-1].replace("A,B,,", "A,X,,")), "a record of the link is not"),
        (BOOM, "joint P is welded to its block"),
    ],
)
def test_what_cannot_be_read_is_said(link, message):
    with pytest.raises(linkages.InputError, match=message):
        linkages.from_pmks(link)
