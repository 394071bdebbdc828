"""What each part of `default` is worth: each removed, and each alone added.

Prints the tables of docs/tracker.md, "Each part removed, each part alone":
    pjpdaf-bench dataset make core --seeds 1 --labels none --export none --out sets/core
    python examples/ablation.py --from sets/core --out ablation.jsonl
Without --from it renders: python examples/ablation.py core --seeds 1

A variant of the tracker is given the detections that `default` led to. Parts of the detector are
tried where the pictures need them: in the group `baseline`, which has the nuisances.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from replays import Result, Variant, by_group, change, main, outcome, share

from scenarios.play.job import System

NUISANCES = ("baseline",)
Settings = Mapping[str, str]


@dataclass(frozen=True)
class Part:
    """A part of `default`: the parameters that remove it, and the part that it acts through."""

    name: str
    off: Settings
    needs: Settings = field(default_factory=dict)


def joined(*settings: Settings) -> Settings:
    """All settings together."""
    return {name: value for one in settings for name, value in one.items()}


DETECTOR = (
    *(
        Part(name, {parameter: "false"})
        for name, parameter in (
            ("noise", "smooth_noise"),
            ("chroma", "test_chroma"),
            ("light", "balance_light"),
            ("the face above the shoulders", "to_shoulders"),
            ("clothes", "split_clothes"),
            ("small clothes of another colour", "clear_clothes"),
            ("the face where the head is expected", "expect_face"),
            ("places that were uncovered", "drop_ghosts"),
            ("rotation of the cameras", "align_views"),
        )
    ),
    Part("deep shadows", {"shadow_min": "0.5"}),
)
# A hand that costs this much is never chosen.
NEVER = "1e6"
OFFSETS = {"hand_offset_m": "0,0,0", "head_offset_m": "0,0,0"}
ENDS, BESIDE = {"ends": "false"}, {"beside_head": "false"}
HALVES, FACE = {"halves": "false"}, {"face": NEVER}
SLEEVES, HYPOTHESES = {"sleeve_weight": "0"}, {"hypotheses": "1"}
TRACKER = (
    Part("pieces beside the head", BESIDE),
    Part("a head in pieces joined", {"join_head": "false"}),
    Part("halves", HALVES),
    Part("halves drawn together", {"draw_together": "0"}, HALVES),
    Part("halves cut in both views at once", {"halve_together": "false"}, HALVES),
    Part("outlines of pieces beside the head", {"contours": "false"}, BESIDE),
    Part("moments of the two views", {"learn_skew": "false"}),
    Part("hands cut by the edge", {"cut_hands": "false"}),
    Part("what one view hides", {"hidden_share": "0"}),
    Part("ends of bare arms", ENDS),
    Part("hands of bare arms that meet", {"middles": "false"}, joined(ENDS, HALVES)),
    Part("strips are no bare arms", {"arm_thickness_m": "0"}, ENDS),
    Part("no hand at the elbow of arms that meet", {"end_and_half": "0"}, ENDS),
    Part("a hand missing beside the head", {"missing_hand": "false"}, BESIDE),
    Part("a head that came nearer", {"nearer_head": "false"}),
    Part("pieces of a bare arm at the start", {"arm_pieces": "false"}),
    Part("head and a lone hand before the start", {"early": "false"}),
    Part("blobs that no arm joins to the person", {"apart": "0"}),
    Part("middle of the palm", {"palm": "0"}),
    Part("sleeves", SLEEVES),
    Part("fingers", {"finger_weight": "0"}, SLEEVES),
    Part("fingers of hands in one blob", {"half_fingers": "0"}, joined(SLEEVES, HALVES)),
    Part("direction of bare arms", {"bare_arm_fingers": "0"}, joined(SLEEVES, ENDS)),
    Part("skin that a sleeve would hide", {"covered_skin": "0"}, SLEEVES),
    Part("fading evidence", {"memory_s": "1e9"}, SLEEVES),
    Part("more than one hypothesis", HYPOTHESES),
    Part("mean of hypotheses", {"mean_within": "0"}, HYPOTHESES),
    Part("rest, movement and fast movement", {"deviations_m": "0.168,0.168,0.168"}),
    Part("fast hands are not named by motion", {"naming_step_m": "0"}),
    Part("a hand that vanishes goes on", {"coast_s": "0"}),
    Part("errors common to both views", {"whole_px": "0.1,2.6", "part_px": "0.1,8.2"}),
    Part("sightings of one view", {"single_view": NEVER}),
    Part("a hand at the face", FACE),
    Part("places before the face", {"face_reach_m": "0"}, FACE),
    Part("a hand behind the head", {"behind": "0"}, FACE),
    Part("blobs want owners", {"unexplained": "0", "unexplained_single": "0"}),
    Part("pieces of face and neck", {"piece": "0"}),
    Part("size of the hands learnt", {"area_memory": "0"}),
    Part("hands that point at the camera", {"tilt": "0"}, {"palm": "0"}),
    Part("hands that point inwards", {"outward_m": "0"}, OFFSETS),
    Part("height of the hair", {"crown_share": "0"}, OFFSETS),
    Part("breadth of the head", {"breadth_share": "0"}, OFFSETS),
    Part("hair beside the face", {"beside_share": "0"}, OFFSETS),
    Part("height of the face", {"height_share": "0"}, OFFSETS),
    Part("offsets to the body's centre", OFFSETS),
)


NO_DETECTOR = joined(*(part.off for part in DETECTOR))
NO_TRACKER = joined(*(part.off for part in TRACKER))


def without(settings: Settings, kept: Settings) -> Settings:
    """The settings whose names are not in `kept`."""
    return {name: value for name, value in settings.items() if name not in kept}


def of_detector(name: str, settings: Settings, tracker: str = "default") -> Variant:
    """A variant of the detector, tried where the nuisances are."""
    return Variant(name, System(tracker=tracker, detector_settings=settings), groups=NUISANCES)


def of_tracker(name: str, settings: Settings) -> Variant:
    """A variant of the tracker."""
    return Variant(name, System(tracker_settings=settings))


WHOLE = Variant("default", System())
REMOVED = (
    *(of_detector(f"without {part.name}", part.off) for part in DETECTOR),
    of_detector("without the parts above", NO_DETECTOR),
    *(of_tracker(f"without {part.name}", part.off) for part in TRACKER),
)
THESIS = Variant("thesis", System("thesis", "thesis"))
EXCHANGED = (
    Variant("detector of default", System("default", "thesis")),
    Variant("tracker of default", System("thesis", "default")),
)
PLAIN_DETECTOR = of_detector("thesis's tracker, components of default", NO_DETECTOR, "thesis")
ADDED_TO_DETECTOR = tuple(
    of_detector(f"with {part.name}", without(NO_DETECTOR, part.off), "thesis") for part in DETECTOR
)
PLAIN_TRACKER = of_tracker("pairs and joint choices alone", NO_TRACKER)
ADDED_TO_TRACKER = tuple(
    of_tracker(f"with {part.name}", without(NO_TRACKER, joined(part.off, part.needs)))
    for part in TRACKER
)
ADDED = (
    *(THESIS, *EXCHANGED),
    *(PLAIN_DETECTOR, *ADDED_TO_DETECTOR),
    *(PLAIN_TRACKER, *ADDED_TO_TRACKER),
)
VARIANTS = (WHOLE, *REMOVED, *ADDED)


def table(title: str, base: Variant, others: tuple[Variant, ...], found: list[Result]) -> None:
    """Print two tables by group: shares and their changes; medians, swaps and losses."""
    mine = {v.name: [r for r in found if r.variant == v.name] for v in (base, *others)}
    of_base = {(result.scenario, result.seed): result for result in mine[base.name]}
    groups = {name: len(results) for name, results in by_group(mine[base.name])}
    if len(groups) == 2:
        groups.pop("all")  # the same as the only group
    # A variant that was tried in some groups only has no figure for all.
    partial = {variant.name for variant in others if variant.groups} - {base.name}

    def rows(heading: str, cell: Callable[[list[Result], bool], str]) -> None:
        print(
            f"\n{heading}\n\n| | " + " | ".join(f"{g}, n = {n}" for g, n in groups.items()) + " |"
        )
        print("|---" * (len(groups) + 1) + "|")
        for name, results in mine.items():
            cells = {g: cell(some, name == base.name) for g, some in by_group(results)}
            if name in partial and len(results) < len(mine[base.name]):
                cells.pop("all", None)
            print(f"| {name} | " + " | ".join(cells.get(g, "") for g in groups) + " |")

    rows(
        f"{title}: within 100 mm, %, and its change in points",
        lambda some, is_base: share(some) if is_base else change(some, of_base),
    )
    rows(
        f"{title}: median of head / hands, mm; episodes swapped, lost",
        lambda some, is_base: outcome(some),
    )


def show(found: list[Result]) -> None:
    """Print the tables of the variants that were tried."""
    tried = {result.variant for result in found}
    for title, base, others in (
        ("Each part removed", WHOLE, REMOVED),
        ("Added to the thesis", THESIS, EXCHANGED),
        ("Parts of the detector alone", PLAIN_DETECTOR, ADDED_TO_DETECTOR),
        ("Parts of the tracker alone", PLAIN_TRACKER, ADDED_TO_TRACKER),
    ):
        if base.name in tried:
            table(title, base, tuple(v for v in others if v.name in tried), found)


if __name__ == "__main__":
    main(
        {"all": VARIANTS, "removed": (WHOLE, *REMOVED), "added": ADDED},
        show,
        "Ablation of the preset default.",
    )
