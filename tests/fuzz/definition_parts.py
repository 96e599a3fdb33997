"""What random changes put into definitions: values, keys, laws, and whole components."""

from hypothesis import strategies as st

NUMBERS = (
    "0", "-0.0", "1", "-1", "0.1", "-2.5", "1e-3", "1e3", "1e-9", "1e9", "1e-30", "1e30", "1e-150",
    "1e150", "1e-200", "1e200", "1e-300", "1e300", "-1e300", "1e308", "5e-324", "1e999", "nan",
    "inf", "-.inf",
)  # fmt: skip
VALUES = (
    *NUMBERS, *NUMBERS, None, "", "~", "x", "t", "pi/2", "1/0", "2**0.5", "90 deg", "-3 mm",
    "10 m", "3 rad", "3 rpm", "5 furlong", "30,5 mm", "left", "right", "ground", "true", "O", "A",
    "B", "a" * 70, "ä", "a.b", "__class__", "stop", "pass", [], ["1"], ["0", "0"], ["1", "2", "3"],
    ["A", "B"], ["A", "A"], ["1e300", "-1e300"], {}, {"x": "1"}, {"A": ["0", "0"]}, [["0"], []],
)  # fmt: skip
KEYS = (
    "mass", "angle", "speed", "position", "law", "joints", "points", "joint", "on", "through",
    "lenght", "a/b", "bars", "sliders", "size", "x", "", "ground", "inertia", "center", "free",
    "drives", "stiffness", "damping", "end", "bar", "bodies",
)  # fmt: skip
LAWS = (
    "t", "t**2", "sin(t)", "1/t", "log(t)", "sqrt(t - 1)", "exp(1000*t)", "0.1*sin(30*t)",
    "1/(t - 0.01)", "abs(t)", "max(t, 0.01)", "1e300*t", "tan(100*t)", "10*t - exp(t)",
    {"harmonic": {"amplitude": "1", "frequency": "2"}},
    {"harmonic": {"amplitude": "1e300", "frequency": "1e300"}},
    {"rise": "cycloidal", "to": "1", "duration": "0.5"},
    {"rise": "polynomial", "from": "0.3", "to": "0.1", "duration": "1e-300"},
    {"table": {"times": ["0", "1", "2"], "values": ["0", "1", "0"]}},
    {"table": {"times": ["0", "1", "2"], "values": ["1e308", "-1e308", "1e308"]}},
    {"table": {"times": ["0", "0.01", "0.02"], "values": ["0", "0.1", "0"], "periodic": "true"}},
    {"run-up": {"speed": "10", "duration": "0.1"}},
)  # fmt: skip
RUNS = (
    {"end": "0.1"}, {"end": "-0.1"}, {"end": "1e-300"}, {"end": "1e300"}, {"rtol": "1e-13"},
    {"method": "rk4", "step": "1e-3"}, {"method": "gauss8", "step": "0.01"}, {"method": "radau"},
    {"samples": "2"}, {"change_points": "pass"}, {"atol": "1e-300"}, {"method": "vern9"},
)  # fmt: skip


@st.composite
def parts(draw, joints, bodies):
    """A section, a name (None where it is a list), and an entry for it."""
    one, other = draw(st.sampled_from(joints)), draw(st.sampled_from(joints))
    body, reference = draw(st.sampled_from(bodies)), draw(st.sampled_from([*bodies, "ground"]))
    number, size = draw(st.sampled_from(NUMBERS)), draw(st.sampled_from(("0.05", "0.3", "1")))
    value = draw(st.sampled_from((number, size, draw(st.sampled_from(LAWS)))))
    ends = {"joints": [one, other]}
    found = (
        ("bars", "new", {**ends, "length": size, "mass": "1"}),
        ("bars", "new", {"joints": [one, "New"], "length": size, "mass": number}),
        ("bars", "plate", {"points": {one: ["0", "0"], other: ["0.1", "0"], "P": ["0", "0.1"]}}),
        ("sliders", "block", {"joint": one, "on": body, "mass": "1"}),
        ("sliders", "block", {"joint": one, "on": body, "through": other, "mass": size}),
        ("sliders", "block", {"joint": one, "through": other, "mass": number}),
        ("sliders", "block", {"joint": one, "angle": number}),
        ("clearances", "gap", {"joint": one, "bar": body, "size": "1e-4", "angle": size}),
        ("clearances", "gap", {"joint": one, "bar": body, "size": number}),
        ("drives", body, {"angle": size, "speed": number}),
        ("drives", body, {"position": size, "speed": number}),
        ("drives", body, {"law": value}),
        ("free", body, {"angle": size, "speed": number}),
        ("free", body, {"position": size, "speed": size}),
        ("assembly", one, draw(st.sampled_from(("left", "right", ["0", "0"])))),
        ("joints", one, ["0.1", size]),
        ("welds", one, {"bars": [body, reference]}),
        ("gears", None, {"bars": [body, reference], "ratio": number}),
        ("springs", None, {"between": [one, other], "stiffness": number, "length": size}),
        ("springs", None, {"bar": body, "stiffness": number, "damping": size}),
        ("springs", None, {"between_bars": [body, reference], "stiffness": "100"}),
        ("dampers", None, {"between": [one, other], "damping": number}),
        ("dampers", None, {"joint": one, "damping": number}),
        ("dampers", None, {"slider": body, "damping": number}),
        ("dampers", None, {"clearance": "gap", "damping": number}),
        ("loads", None, {"joint": one, "force": [value, size]}),
        ("loads", None, {"slider": body, "force": value}),
        ("loads", None, {"bar": body, "torque": value}),
        ("masses", one, number),
        ("gravity", "", ["0", draw(st.sampled_from(("9.81", number)))]),
        ("simulate", "", draw(st.sampled_from(RUNS))),
    )
    return draw(st.sampled_from(found))
