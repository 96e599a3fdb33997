"""Wear over revolutions as labelled arrays, and what is to be said of it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.options.analysis_options import WearOptions
from linkages.tribology.steady_work import PRECISION
from linkages.tribology.worn_bearings import ANGLES

if TYPE_CHECKING:
    import xarray as xr

    from linkages.tribology.cycle_jumps import Jumps, Place

Floats = NDArray[np.float64]

FITTING = 0.5
"""Clearance of a journal in a pocket, over that all around, below which it is said to fit."""

LOCAL = 2.0
"""Depth of wear over that all around from which on it is said."""


def notes_of(jumps: Jumps, run: WearOptions) -> list[str]:
    """What is to be said of a result."""
    places, names = jumps.places, [joint.name for joint in jumps.joints]
    result = []
    for k, name in enumerate(names):
        errors = [p.here.error[k] / max(p.here.work[k], 1e-300) for p in places if p.here.work[k]]
        worst = max(errors, default=0.0)
        if worst > PRECISION * run.accuracy:
            result.append(
                f"clearance {name}: means of {run.longest} revolutions have standard errors of up "
                f"to {worst:.1%}; more of them (longest) lower the error"
            )
        away = max(float(p.here.away[k]) for p in places)
        if away > 0.0:
            result.append(
                f"clearance {name}: a massless link has no contact that opens; up to {away:.0%} of "
                "the work is done while it pushes, where a real journal would have changed sides"
            )
        if not jumps.joints[k].harmonics:
            result += _local(name, places[-1].profile[k])
        else:
            result += _fitting(name, jumps.joints[k].curvature(*_worn_at(places[-1], k)))
        journal = jumps.joints[k].depths(float(places[-1].work[k]))[0]
        if jumps.joints[k].turns and journal > 0.05 * jumps.joints[k].radii[0]:
            result.append(f"clearance {name}: the journal has lost {journal:.3g} m of its radius")
    if not all(place.here.trusted for place in places):
        result.append("some means are correlated as long as their series: their errors are guesses")
    if jumps.forced:
        result.append(
            f"{jumps.forced} jumps were made at the least length although their error is larger: "
            "there the motion changes suddenly with the clearance"
        )
    return result


def _worn_at(place: Place, k: int) -> tuple[float, Floats]:
    return float(place.work[k]), place.depths[k]


def _fitting(name: str, curvature: Floats) -> list[str]:
    """Where a journal fits into its bearing, which laws of contact are not made for."""
    fits = curvature < FITTING * float(curvature.mean())
    if not fits.any():
        return []
    return [
        f"clearance {name}: the journal fits into {360 * fits.mean():.0f}° of its bearing, where "
        f"motions see a clearance of {float(curvature.min()):.3g} m at least: it touches along an "
        "arc there, or at two places at once, and the law of contact of one place is extrapolated"
    ]


def _local(name: str, profile: Floats) -> list[str]:
    """How much deeper wear is where it arises than it would be all around."""
    result = []
    for side, depth in zip(("journal", "bearing"), profile, strict=True):
        around, most = float(depth.mean()), float(depth.max())
        if around > 0.0 and most > LOCAL * around:
            result.append(
                f"clearance {name}: where it arises, wear of the {side} is up to {most:.3g} m "
                f"deep, {most / around:.2g} times as deep as all around; the size is that of "
                "uniform wear"
            )
    return result


def wear_dataset(
    mechanism: Mechanism,
    jumps: Jumps,
    run: WearOptions,
    ended: str,
    difference: Floats | None,
) -> xr.Dataset | None:
    """What there is as labelled arrays; None if there is nothing."""
    import xarray as xr

    places, joints, period = jumps.places, jumps.joints, jumps.means.motions.period
    if not places:
        return None
    of = ("jump", "clearance")
    sizes = np.array([jumps.sizes(place) for place in places])
    errors = np.array([jumps.growth(place, place.error) for place in places])
    if difference is not None:
        errors[-1] = np.maximum(errors[-1], difference)
    volumes = np.array([
        [joint.volumes(work) for joint, work in zip(joints, place.work.tolist(), strict=True)]
        for place in places
    ])  # fmt: skip
    work = np.array([place.here.work for place in places])
    areas = np.array([joint.area for joint in joints])
    pressure = np.stack(
        [work / period / areas, np.array([place.here.peak for place in places])], axis=-1
    )
    data: dict[str, Any] = {
        "revolutions": ("jump", np.array([p.revolutions for p in places]), {"units": "1"}),
        "size": (of, sizes, {"units": "m", "long_name": "radial clearance"}),
        "error": (of, errors, {"units": "m", "long_name": "error of the radial clearance"}),
        "volume": ((*of, "side"), volumes, {"units": "m^3", "long_name": "worn volume"}),
        "depth": (
            (*of, "side", "angle"), np.array([place.profile for place in places]),
            {"units": "m", "long_name": "depth of wear where it arises"},
        ),
        "sliding_distance": (
            of, np.array([place.slid for place in places]),
            {"units": "m", "long_name": "distance of slip"},
        ),
        "work": (
            of, work, {"units": "J", "long_name": "work of the normal force along the slip"},
        ),
        "work_error": (of, np.array([place.here.error for place in places]), {"units": "J"}),
        "pressure_velocity": (
            (*of, "of"), pressure,
            {"units": "W/m^2", "long_name": "nominal pressure by velocity of slip"},
        ),
    }  # fmt: skip
    if run.feedback == "profile":
        thinner = np.array([
            [joint.depths(w)[0] for joint, w in zip(joints, place.work.tolist(), strict=True)]
            for place in places
        ])  # fmt: skip
        data["profile"] = (
            (*of, "angle"), np.array([place.depths for place in places]) + thinner[:, :, None],
            {"units": "m", "long_name": "radial clearance over the angle of the bearing"},
        )  # fmt: skip
    coords = {
        "jump": np.arange(len(places)),
        "clearance": [joint.name for joint in joints],
        "side": ["journal", "bearing"],
        "of": ["mean", "largest"],
        "angle": ("angle", ANGLES, {"units": "rad"}),
    }
    attrs: dict[str, Any] = {
        "name": mechanism.name, "source": mechanism.file_name, "period": period, "ended": ended,
        "computed": jumps.means.revolutions, "notes": json.dumps(notes_of(jumps, run)), **run.how,
        "worn": json.dumps(jumps.means.motions.values(places[-1].work, places[-1].depths)),
    }  # fmt: skip
    if difference is not None:
        attrs["difference"] = difference
    return xr.Dataset(data, coords, attrs)
