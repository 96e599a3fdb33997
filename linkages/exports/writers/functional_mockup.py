"""Mechanisms as functional mock-up units: description, source and library in one archive.

Functional Mock-up Interface 3.0.2 and 2.0.5, Modelica Association, fmi-standard.org.
"""

from __future__ import annotations

import io
import platform
import shutil
import subprocess
import sys
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from linkages.components.contributed.functions import Number
from linkages.components.contributed.load_measures import Load, Measure
from linkages.components.contributed.terms import Parameter
from linkages.components.mechanisms.registry import bound_at
from linkages.equilibria.ports import force_channels, found_input
from linkages.exports import Subject
from linkages.exports.texts import fixed_text
from linkages.exports.writers.exported_model import Exported, exported
from linkages.exports.writers.source_code import (
    c_array,
    c_header,
    c_name,
    c_program,
    c_texts,
    filled,
    named_in_c,
)
from linkages.kernel.system import System
from linkages.options.option import OptionError
from linkages.solution.stop_messages import joint_of
from linkages.spec.units import Bound, UnitError, unit

VERSIONS = ("3.0", "2.0")
COMPILERS = ("cc", "gcc", "clang")
OPTIONS = ("-std=c99", "-O2", "-shared", "-fPIC", "-fvisibility=hidden")
TOLERANCE = 1e-10
"""Relative, of steps in co-simulation where a master gives none."""

CROSSING = 1e-3
"""Seconds in which a pin usually crosses its clearance."""

INPUTS = "inputs"
ACCELERATION = ".acceleration"
"""Of a drive, beyond that of its law."""


@dataclass(frozen=True)
class _Channel:
    """A variable of the unit.

    `about`: causality, variability and initial, as far as they are stated.
    `start`: its value if it can be set.
    `least`: whether it is not negative.
    `written`, `size`: the unit that the file has it in, and what one of that is in SI.
    `state`: which variable it is the derivative of.
    `nominal`: its usual size if it is a state; errors are parts of that.
    """

    name: str
    about: tuple[str, str, str]
    unit: str = ""
    start: float | None = None
    least: bool = False
    written: str = ""
    size: float = 1.0
    state: int | None = None
    nominal: float = 0.0
    text: str = ""
    whole: bool = False


_INDICATOR = "event indicator: changes its sign where the mode changes"
_NEAR = "event indicator: changes its sign where a change point comes close"
_PARAMETER = "parameter", "fixed", "exact"
_INPUT = "input", "continuous", ""
_LOCAL = "local", "continuous", "calculated"
_OUTPUT = "output", "continuous", "calculated"


def fmu_files(
    subject: Subject, version: str, inputs: Sequence[str]
) -> tuple[Mapping[str, bytes], str]:
    """The archive under its name, and a note if it holds no library."""
    if version not in VERSIONS:
        expected = f"expected one of: {', '.join(VERSIONS)}"
        raise OptionError("fmi", f"unknown version {version!r}; {expected}")
    names, found = _pushed(subject, inputs)
    identifier = c_name(subject.name)
    variables = _variables(found, names)
    rows = _state_rows(found)
    bounds = [_bound(found, number.path) for number in found.feed.numbers]
    parts = [
        filled(fixed_text("fmi_types.c"), {"VERSION": version[0], "TOLERANCE": repr(TOLERANCE)}),
        c_header(found),
        c_program(found),
        f"enum {{ INPUTS = {len(names)}, STATES = {len(rows)}, "
        f"CHANGE_POINTS = {len(_change_points(found))} }};",
        c_array("static const int INPUT_PLACES", found.inputs or ()),
        c_array("static const int STATE_ROWS", rows),
        c_array("static const double NOMINALS", [v.nominal for v in variables if v.nominal]),
        c_array("static const int BOUNDS", [[*Bound].index(bound) for bound in bounds]),
        "static " + c_texts("INPUT_NAMES", [name for name, _ in names]),
        fixed_text("fmu.c"),
        fixed_text("fmi.c"),
    ]
    source = named_in_c("\n".join(parts), identifier)
    described = _description(subject, found, identifier, version, variables)
    token = f"{{{uuid.uuid5(uuid.NAMESPACE_URL, source + described)}}}"
    source, described = (text.replace("@TOKEN@", token) for text in (source, described))
    files = {
        "modelDescription.xml": described.encode(),
        f"sources/{identifier}.c": source.encode(),
    }
    if version == "3.0":
        files["sources/buildDescription.xml"] = _build(identifier).encode()
    library, note = _compiled(source, identifier)
    if library:
        ending = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
        files[f"binaries/{_platform(version)}/{identifier}{ending}"] = library
    return {f"{subject.name}.fmu": archive(files)}, note


def archive(files: Mapping[str, bytes]) -> bytes:
    """A ZIP archive that depends on its content alone."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as out:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name)
            entry.external_attr = 0o644 << 16
            out.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return memory.getvalue()


def _pushed(subject: Subject, asked: Sequence[str]) -> tuple[list[tuple[str, str]], Exported]:
    """Names and units of inputs, and the mechanism with a load or a deviation for each."""
    system = subject.system
    mechanism = system.mechanism
    given = {load.label for load in system.model.loads if load.load.given}
    known: dict[str, tuple[str, str, Measure | str, bool]] = {
        each[0]: each for each in force_channels(system, system.topology.free)
    }
    for drive in system.topology.driven:
        name = f"{drive}{ACCELERATION}"
        unit = "rad/s^2" if mechanism.bodies[drive].rotates else "m/s^2"
        known[name] = (name, unit, drive, False)
    usual = [name for name, *_, own in known.values() if own or name in given]
    names = [asked] if isinstance(asked, str) else [*asked]
    chosen = [known[found_input(known, usual, name)] for name in dict.fromkeys(names) or usual]
    paths = [(INPUTS, name) for name, *_ in chosen]
    given_numbers = [Parameter(path, 1.0) for path in paths]
    loads, deviations = list[Load](), dict[str, Parameter]()
    for path, number, (_, _, along, _) in zip(paths, given_numbers, chosen, strict=True):
        if isinstance(along, str):
            deviations[along] = number
        else:
            loads.append(Load(along, Number(number), path))
    pushed = System(mechanism.with_deviations(deviations).with_loads(loads))
    found = exported(pushed, run=subject.simulation, inputs=paths)
    return [(name, unit) for name, unit, *_ in chosen], found


def _state_rows(found: Exported) -> list[int]:
    """Places of continuous states: free coordinates, their rates, internal states."""
    layout = found.system.layout
    n, free = len(layout.coordinates), len(layout.free)
    return [*range(free), *range(n, n + layout.moved)]


def _change_points(found: Exported) -> list[str]:
    """Joints of the blocks whose change points a motion may pass in model exchange."""
    model = found.system.model
    blocks = found.system.topology.solved_blocks if found.passing and len(found.state) else ()
    return [joint_of(model, block) for block in blocks]


def _bound(found: Exported, path: str) -> Bound:
    return bound_at(found.system.mechanism.definition, path)


def _variables(found: Exported, inputs: Sequence[tuple[str, str]]) -> list[_Channel]:
    """All variables in the order of their references, as `fmu.c` counts them."""
    result = [_Channel("time", ("independent", "continuous", ""), "s")]
    for number in found.feed.numbers:
        least = _bound(found, number.path) is not Bound.NONE
        shown = number.written if number.unit and number.written != number.unit else ""
        result.append(
            _Channel(number.path, _PARAMETER, number.unit, number.value, least, shown, number.size)
        )
    result += [_Channel(name, _INPUT, unit, 0.0) for name, unit in inputs]
    first, states = len(result), _states(found)
    result += [state for state, _ in states]
    result += [
        _Channel(f"der({state.name})", _LOCAL, unit, state=first + k)
        for k, (state, unit) in enumerate(states)
    ]
    result += [_Channel(f"event.{name}", _LOCAL, text=_INDICATOR) for name in found.modes]
    result += [
        _Channel(f"event.change point of {joint}", _LOCAL, text=_NEAR)
        for joint in _change_points(found)
    ]
    result += [_Channel(q.name, _OUTPUT, q.unit, text=q.label) for q in found.quantities]
    about = "local", "discrete", "calculated"
    text = "1 or -1: side of zero of its function; 0: sticks"
    result += [_Channel(f"mode.{name}", about, text=text, whole=True) for name in found.modes]
    return _distinct(result)


def _states(found: Exported) -> list[tuple[_Channel, str]]:
    """Continuous states, each with the unit of its rate."""
    layout, mechanism = found.system.layout, found.system.mechanism
    gaps = {contact.path: contact.size.value for contact in mechanism.contacts}
    n, free = len(layout.coordinates), len(layout.free)
    result = []
    for row in _state_rows(found):
        name = layout.coordinates[row % n]
        if row % n >= free:
            state = mechanism.internal[name]
            made = _Channel(f"state.{name}", _LOCAL, state.unit, nominal=state.scale or 1.0)
            result.append((made, f"{state.unit}/s"))
            continue
        body = mechanism.bodies[name]
        base, usual = "rad" if body.rotates else "m", gaps.get(body.path, 1.0)
        if row < n:
            made = _Channel(f"state.{name}", _LOCAL, base, nominal=usual)
            result.append((made, f"{base}/s"))
        else:
            fast = usual / CROSSING if body.path in gaps else usual
            made = _Channel(f"state.{name}.rate", _LOCAL, f"{base}/s", nominal=fast)
            result.append((made, f"{base}/s^2"))
    return result


def _distinct(variables: Sequence[_Channel]) -> list[_Channel]:
    """The same, with a number behind a name that is taken."""
    taken: set[str] = set()
    result = []
    for variable in variables:
        name, count = variable.name, 2
        while name in taken:
            name, count = f"{variable.name} ({count})", count + 1
        taken.add(name)
        result.append(replace(variable, name=name))
    return result


def _description(
    subject: Subject,
    found: Exported,
    identifier: str,
    version: str,
    variables: Sequence[_Channel],
) -> str:
    """The model description; the token is left open."""
    from linkages import __version__

    new, mechanism = version == "3.0", found.system.mechanism
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": mechanism.name,
            ("instantiationToken" if new else "guid"): "@TOKEN@",
            "description": "Equations of motion of a planar linkage, in SI",
            "generationTool": f"linkages {__version__}",
            "variableNamingConvention": "flat",
        },
    )
    if not new:
        root.set("numberOfEventIndicators", str(len(found.modes) + len(_change_points(found))))
    state, plural = ("State", "s") if new else ("state", "")
    can = {
        "modelIdentifier": identifier,
        f"canGetAndSetFMU{state}": "true",
        f"canSerializeFMU{state}": "true",
        f"providesDirectionalDerivative{plural}": "true",
    }
    exchange = {"needsCompletedIntegratorStep": "true"} if new else {}
    kinds = [
        SubElement(root, "ModelExchange", can | exchange),
        SubElement(root, "CoSimulation", {**can, "canHandleVariableCommunicationStepSize": "true"}),
    ]
    if not new:
        for kind in kinds:
            SubElement(SubElement(kind, "SourceFiles"), "File", name=f"{identifier}.c")
    _units(root, variables)
    SubElement(SubElement(root, "LogCategories"), "Category", name="logStatusError")
    times = {"startTime": "0.0", "stopTime": repr(abs(float(subject.simulation.end)))}
    SubElement(root, "DefaultExperiment", {**times, "tolerance": repr(TOLERANCE)})
    listed = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        _variable(listed, reference, variable, new)
    _structure(SubElement(root, "ModelStructure"), variables, new)
    return _xml(root)


def _xml(root: Element) -> str:
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, "unicode") + "\n"


def _units(root: Element, variables: Sequence[_Channel]) -> None:
    """Units by their base units, each with those that the definition file is written in."""
    shown: dict[str, dict[str, float]] = {}
    for variable in variables:
        own = shown.setdefault(variable.unit, {})
        if variable.written:
            own[variable.written] = variable.size
    names = {
        "kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "mole": "mol",
        "candela": "cd", "radian": "rad",
    }  # fmt: skip
    defined = SubElement(root, "UnitDefinitions")
    for name in sorted(shown.keys() - {""}):
        element = SubElement(defined, "Unit", name=name)
        try:
            powers = unit(name).exponents
        except UnitError:  # of drives of which some turn and some push
            powers = ()
        whole = all(power == int(power) and base in names for base, power in powers)
        if whole and (powers or name == "1"):
            SubElement(element, "BaseUnit", {names[base]: str(int(p)) for base, p in powers})
        for other, size in sorted(shown[name].items()):
            SubElement(element, "DisplayUnit", name=other, factor=repr(1.0 / size))


def _variable(listed: Element, reference: int, variable: _Channel, new: bool) -> None:
    """What a variable is, and of its value unit, range and start."""
    causality, variability, initial = variable.about
    about = {
        "name": variable.name,
        "valueReference": str(reference),
        "causality": causality,
        "variability": variability,
        "initial": initial,
        "description": variable.text,
    }
    value = {
        "unit": variable.unit,
        "displayUnit": variable.written,
        "nominal": repr(variable.nominal) if variable.nominal else "",
        "min": "0.0" if variable.least else "",
        "start": "" if variable.start is None else repr(variable.start),
        "derivative": "" if variable.state is None else str(variable.state + (not new)),
    }
    about, value = ({k: v for k, v in part.items() if v} for part in (about, value))
    if new:
        SubElement(listed, "Int32" if variable.whole else "Float64", about | value)
    else:
        element = SubElement(listed, "ScalarVariable", about)
        SubElement(element, "Integer" if variable.whole else "Real", value)


def _structure(root: Element, variables: Sequence[_Channel], new: bool) -> None:
    """Which variables are outputs, derivatives, indicators, and not known at the start."""
    places = range(len(variables))
    outputs = [k for k in places if variables[k].about == _OUTPUT]
    rates = [k for k in places if variables[k].state is not None]
    states = [k for k in places if variables[k].nominal]
    indicators = [k for k in places if variables[k].text in (_INDICATOR, _NEAR)]
    parts = {
        "Output": outputs,
        "ContinuousStateDerivative" if new else "Derivative": rates,
        "InitialUnknown": sorted([*outputs, *rates, *states]),
        "EventIndicator": indicators if new else [],
    }
    for title, own in parts.items():
        part = root if new or not own else SubElement(root, f"{title}s")
        for k in own:
            if new:
                SubElement(part, title, valueReference=str(k))
            else:
                SubElement(part, "Unknown", index=str(k + 1))


def _build(identifier: str) -> str:
    """How the source of a unit of version 3.0 is compiled."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = SubElement(build, "SourceFileSet", language="C99")
    SubElement(files, "SourceFile", name=f"{identifier}.c")
    SubElement(build, "Library", name="m")
    return _xml(root)


def _platform(version: str) -> str:
    """The folder of libraries for this machine."""
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    if version == "2.0" and machine == "x86_64":
        return f"{system.removesuffix('dows')}64"
    return f"{machine}-{system}"


def _compiled(source: str, identifier: str) -> tuple[bytes, str]:
    """A library, or why there is none."""
    compiler = next((path for name in COMPILERS if (path := shutil.which(name))), None)
    if compiler is None:
        return b"", f"source only: found no C compiler; expected {', '.join(COMPILERS)} on the PATH"
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{identifier}.c"
        file.write_text(source, encoding="utf-8")
        command = [compiler, *OPTIONS, file.name, "-o", "library", "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            why = (done.stderr.strip().splitlines() or ["no message"])[0]
            return b"", f"source only: {compiler} failed: {why}"
        return (Path(folder) / "library").read_bytes(), ""
