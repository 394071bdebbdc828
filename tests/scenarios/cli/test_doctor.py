"""`doctor` on this machine, and with a broken setting."""

import pickle

from commands import in_this_process

from pjpdaf.errors import InfrastructureError


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
    assert "FAIL offscreen OpenGL: MUJOCO_GL=potato is no OpenGL back end" in bad.stdout
    assert "     -> unset MUJOCO_GL to have one chosen" in bad.stdout


def test_a_fault_of_the_machine_keeps_cause_and_remedy_between_processes():
    fault = pickle.loads(pickle.dumps(InfrastructureError("no OpenGL; at all", "install it")))
    assert str(fault) == "no OpenGL; at all; install it"
    assert (fault.cause, fault.remedy) == ("no OpenGL; at all", "install it")
    assert str(InfrastructureError("the disk is full")) == "the disk is full"
