"""A sequence of a data set, or a frame of it, made again from its recipe."""

import pytest
from made_dataset import contents, made_dataset

from scenarios.dataset.remake import remake_sequence


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return made_dataset(tmp_path_factory)


@pytest.mark.long
def test_a_recipe_makes_a_sequence_and_a_frame_of_it_again(made, tmp_path):
    for number in (1, 2):  # of a pair of twins; with a clip, which lies beside it
        folder = made / f"seq_{number:06d}"
        message = remake_sequence(folder / "recipe.json", tmp_path / f"again{number}")
        assert message == f"sequence: {tmp_path / f'again{number}'}"
        assert contents(tmp_path / f"again{number}") == contents(folder)
        remake_sequence(folder / "recipe.json", tmp_path / f"one{number}", frame=2)
        pictures = {k: v for k, v in contents(tmp_path / f"one{number}").items() if "/" in k}
        assert set(pictures) == {
            f"{kind}_{side}/000003.png".lstrip("_")
            for kind in ("", "depth", "seg")
            for side in ("left", "right")
        }
        assert pictures.items() <= contents(folder).items()
