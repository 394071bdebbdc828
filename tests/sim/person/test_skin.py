"""Skin: uneven, yet all of it within what a skin-colour detector takes for skin."""

import colorsys

import cv2
import numpy as np
import pytest

from scenarios.spec.person_and_room import skin_rgb
from sim.person.face import EXPRESSIONS, face_texture
from sim.person.hair import HAIR
from sim.person.skin import hand_marks, hand_texture, skin_texture
from sim.specs import Appearance

TONES = tuple(skin_rgb(np.radians(ita)) for ita in (-45.0, -10.0, 20.0, 45.0, 58.0))


def rng():
    return np.random.default_rng(7)


def hue_and_saturation(picture):
    hsv = cv2.cvtColor(picture[..., ::-1].astype(np.float32) / 255, cv2.COLOR_BGR2HSV)
    return (hsv[..., 0] + 180) % 360 - 180, hsv[..., 1]


@pytest.mark.parametrize("tone", TONES)
def test_hands_vary_but_stay_skin(tone):
    h, s, _ = colorsys.rgb_to_hsv(*tone)
    for picture in (hand_texture(rng(), tone), skin_texture(rng(), tone)):
        hue, saturation = hue_and_saturation(picture)
        # A detector learns hue and saturation of a face and allows for some 15 degrees and 0.15.
        assert np.abs(hue - 360 * h).max() < 12
        assert np.percentile(np.abs(saturation - s), 99) < 0.10
        mean = picture.reshape(-1, 3).mean(axis=0) / 255
        np.testing.assert_allclose(mean, tone, rtol=0.05)
    assert picture.std(axis=(0, 1)).min() > 0.5


def test_knuckles_are_redder_nails_lighter_and_creases_darker():
    tone = TONES[2]
    marks, picture = hand_marks(), hand_texture(rng(), tone).astype(float)
    plain = (marks.crease < 0.05) & (marks.nail < 0.05) & (marks.flushed < 0.05)
    red = picture[..., 0] / picture[..., 1]
    knuckles = plain_but(marks, "flushed")
    assert red[knuckles].mean() > 1.03 * red[plain].mean()
    assert picture[plain_but(marks, "nail")].mean() > 1.02 * picture[plain].mean()
    assert picture[marks.crease > 0.6].mean() < 0.92 * picture[plain].mean()


def plain_but(marks, name):
    others = [getattr(marks, n) for n in ("crease", "flushed", "nail") if n != name]
    return (getattr(marks, name) > 0.6) & (np.max(others, axis=0) < 0.2)


def test_a_face_has_its_expression_and_only_the_front_of_it_changes():
    faces = {}
    for expression in EXPRESSIONS:
        faces[expression] = face_texture(rng(), Appearance(expression=expression)).astype(int)
    neutral = faces.pop("neutral")
    for expression, face in faces.items():
        changed = np.abs(face - neutral).max(axis=-1) > 12
        assert 0.002 < changed.mean() < 0.12, expression
        rows, columns = np.nonzero(changed)
        assert columns.min() > 0.2 * face.shape[1]
        assert columns.max() < 0.8 * face.shape[1]
        below = rows > 0.5 * face.shape[0]
        if expression == "open_mouth":
            assert below.mean() > 0.4
            assert face[changed].min() < 45  # the dark behind the teeth
    assert (np.abs(faces["smile"] - faces["brows_up"]).max(axis=-1) > 12).any()


def test_each_cut_has_its_own_hairline_on_the_skin():
    """Roots are painted: a receding line leaves more of the forehead bare than any other."""
    bare = {}
    for hair in HAIR:
        face = face_texture(rng(), Appearance(hair=hair))
        bare[hair] = (face.max(axis=-1) > 120).mean()
    assert bare["bald"] == max(bare.values())
    assert bare["receding"] > max(bare[cut] for cut in ("short", "long", "curly", "parted"))
