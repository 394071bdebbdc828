"""The families that stress searches: a scenario each, and which of its parameters vary."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from pjpdaf.errors import BenchError
from scenarios.spec.names import is_path, load_scenario, scenario_names
from scenarios.spec.own_motion import is_own_motion
from scenarios.spec.parameters.choice import Choice
from scenarios.spec.parameters.distributions import Fixed
from scenarios.spec.parameters.file import File
from scenarios.spec.parameters.numeric import Numeric
from scenarios.spec.scenario import Scenario
from scenarios.spec.suggestion import did_you_mean, suggestion

# Not a parameter of a scenario, but a field that may be changed: searched and mapped as one.
FPS = Numeric(
    unit="Hz", range=(1.0, 30.0), nominal=Fixed(kind="fixed", value=3.0), meaning="frames a second"
)
_RIG = ("baseline", "rig_height", "rig_tilt", "rig_distance")
_NUISANCES = (
    *("skin_ita", "sleeves", "hair", "near_skin", "shirt_hue", "shirt_value"),
    *("light_gain", "light_temperature", "light_azimuth", "shadow", "mover", "background_change"),
    *("start", "noise_sd", "shot_noise", "jpeg_quality", "exposure_time", "exposure"),
    *("white_balance", "flicker", "flicker_rate", "shutter_skew", "jitter", "stamps", "dropped"),
    *("principal_x", "principal_y", "calibration_baseline", "calibration_focal"),
    *("calibration_rot_x", "calibration_rot_y", "calibration_rot_z"),
)


@dataclass(frozen=True)
class StressFamily:
    """A family to search: the scenario, and the standard parameters that vary beside its own.

    ranges: of a parameter whose whole range cannot be played; fast: whether the fast fidelity knows
    what varies (docs/stress_fast.md), else it is searched in full unless asked for otherwise.
    """

    name: str
    scenario_name: str
    standard: tuple[str, ...] = ()
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    fast: bool = True

    @property
    def scenario(self) -> Scenario:
        """Its scenario, as shipped."""
        return load_scenario(self.scenario_name)

    @property
    def target(self) -> str:
        """What `find_family` finds it by: its name, or the file or plug-in of its scenario."""
        return self.scenario_name if is_own(self.scenario_name) else self.name

    @property
    def searched(self) -> tuple[str, ...]:
        """Names of the parameters that vary: the family's own, then the standard ones."""
        scenario = self.scenario
        own = scenario.motion_family.parameters
        given = (name for name in scenario.parameters if name in own)
        files = {n for n, parameter in scenario.parameters.items() if isinstance(parameter, File)}
        return tuple(name for name in (*given, *self.standard) if name not in files)

    def parameter(self, name: str) -> Numeric | Choice:
        """A parameter of its scenario, or `FPS`. Raises BenchError for any other name."""
        parameters = self.scenario.parameters
        parameter = FPS if name == "fps" else parameters.get(name)
        if not isinstance(parameter, Numeric | Choice):
            known = [n for n, p in parameters.items() if not isinstance(p, File)]
            hint = did_you_mean(name, [*known, "fps"]) or f"; known: {', '.join(self.searched)}"
            raise BenchError(f"{self.name} has no parameter {name[:60]!r} to vary{hint}")
        return parameter


def _motion(name: str) -> StressFamily:
    return StressFamily(name, name)


def is_own(name: str) -> bool:
    """Whether a name is that of a scenario file, or of a plug-in's motion."""
    return name not in scenario_names() and (is_path(name) or is_own_motion(name))


# The shipped clip lasts 12.4 s.
_RECORDED = StressFamily(
    "recorded", "recorded", _RIG, {"clip_start": (0.0, 10.0), "slow": (1.0, 4.0)}
)
FAMILIES: Mapping[str, StressFamily] = {
    family.name: family
    for family in (
        _motion("cross"),
        _motion("bounce"),
        _motion("merge_and_hold"),
        _motion("drink"),
        _motion("both_hands_to_head"),
        _motion("mirror"),
        _motion("parallel"),
        _motion("fast_finish"),
        _motion("one_view_occluder"),
        _motion("object_splits_hand"),
        _motion("roll_forearms"),
        _RECORDED,
        StressFamily("nuisances", "natural_table", _NUISANCES, fast=False),
    )
}


def find_family(name: str) -> StressFamily:
    """A family by name; any other shipped scenario is one too, with its own parameters.

    So is a scenario file, and a plug-in's motion. Raises BenchError with the closest name.
    """
    if name in FAMILIES:
        return FAMILIES[name]
    if name in scenario_names():
        return _motion(name)
    if is_own(name):
        return StressFamily(load_scenario(name).name, name)
    if name == "all" or "," in name:
        raise BenchError(f"{name[:60]}: one case at a time; name one family, or a CASE.yaml")
    known = tuple(dict.fromkeys((*FAMILIES, *scenario_names())))
    hint = suggestion(name, known, "pjpdaf-bench scenarios list")
    raise BenchError(f"no family {name[:60]!r} to stress{hint}")
