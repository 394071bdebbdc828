"""Pictures of scenarios and their captions."""

import numpy as np
import pytest
from made_truth import truth

from scenarios.catalogue import pictures
from scenarios.catalogue.stored_picture import picture_from_bytes, picture_to_bytes
from scenarios.execute.journal import Journal
from scenarios.spec.names import load_scenario
from sim.processes import WorkerPool


def test_captions_say_what_is_merged_and_what_is_not_seen():
    assert pictures.caption(truth(6, ("reach", "merge:a+b:left_view"), merged=1)) == (
        "frame 6 (2.0 s), reach, R+L merged in both views"
    )
    assert pictures.caption(truth(0, visible=0)) == "frame 0 (0.0 s), R unseen in both views"


@pytest.mark.long
def test_pictures_of_scenarios_are_drawn_in_worker_processes_once(tmp_path):
    frames = {"cross": 18, "bounce": 18}  # until they are merged
    scenarios = [load_scenario(n).model_copy(update={"frames": f}) for n, f in frames.items()]
    with WorkerPool(1) as pool, Journal.open(tmp_path / "a.part", "one") as journal:
        drawn = pictures.draw_scenarios(scenarios, pool, journal)
    for picture in drawn:
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

    class Refusing:
        def running_steps(self):
            return 0

        def outcomes(self, function, tasks, limit_s):
            assert not tasks, "what is kept is not drawn again"
            return iter(())

    with Journal.open(tmp_path / "a.part", "one") as journal:
        again = pictures.draw_scenarios(scenarios, Refusing(), journal)
    for one, other in zip(drawn, again, strict=True):
        assert one.caption == other.caption
        np.testing.assert_array_equal(one.large, other.large)
        np.testing.assert_array_equal(one.small, other.small)


@pytest.mark.parametrize("cut", [0, 3, 10, 40, -1])
def test_a_damaged_picture_is_refused(cut):
    image = np.zeros((4, 5, 3), np.uint8)
    data = picture_to_bytes(pictures.ScenarioPicture(image, image, "ünter"))
    assert picture_from_bytes(data).caption == "ünter"
    with pytest.raises(ValueError, match="is no"):
        picture_from_bytes(data[:cut])
    with pytest.raises(ValueError, match="is no"):
        picture_from_bytes(data[:20] + bytes(len(data) - 20))
