"""`doctor` on this machine, and with a broken setting."""

from commands import bench


def test_doctor_is_content_here_and_not_with_a_broken_mujoco_gl():
    good = bench("doctor")
    assert good.returncode == 0, good.stdout
    assert "self-test" in good.stdout
    assert "FAIL" not in good.stdout
    bad = bench("doctor", MUJOCO_GL="potato")
    assert bad.returncode == 5
    assert "FAIL" in bad.stdout
    assert "potato" in bad.stdout
