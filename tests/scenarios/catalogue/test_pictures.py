"""Pictures of scenarios and their captions."""

from made_truth import truth

from scenarios.catalogue import pictures
from scenarios.spec.names import load_scenario


def test_captions_say_what_is_merged_and_what_is_not_seen():
    assert pictures.caption(truth(6, ("reach", "merge:a+b:left_view"), merged=1)) == (
        "frame 6 (2.0 s), reach, R+L merged in both views"
    )
    assert pictures.caption(truth(0, visible=0)) == "frame 0 (0.0 s), R unseen in both views"


def test_pictures_of_scenarios_are_drawn_in_worker_processes():
    frames = {"cross": 18, "bounce": 18}  # until they are merged
    scenarios = [load_scenario(n).model_copy(update={"frames": f}) for n, f in frames.items()]
    for picture in pictures.draw_scenarios(scenarios, workers=1):
        assert picture.large.shape == (
            pictures.PAGE_PX,
            2 * pictures.PAGE_PX + 4,
            3,
        )
        assert picture.small.shape == (
            pictures.MARKDOWN_PX,
            2 * pictures.MARKDOWN_PX + 4,
            3,
        )
        assert "R+L merged" in picture.caption
        assert picture.caption.startswith("frame ")
