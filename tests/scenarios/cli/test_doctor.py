"""`doctor` on this machine, and with a broken setting."""

from commands import in_this_process


def test_doctor_is_content_here_and_not_with_a_broken_mujoco_gl(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    good = in_this_process("doctor")
    assert good.returncode == 0, good.stdout
    assert "self-test" in good.stdout
    assert "FAIL" not in good.stdout
    monkeypatch.setenv("MUJOCO_GL", "potato")
    bad = in_this_process("doctor")
    assert bad.returncode == 5
    assert "FAIL" in bad.stdout
    assert "potato" in bad.stdout
