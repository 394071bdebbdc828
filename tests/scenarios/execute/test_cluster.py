"""Tasks on a real Dask scheduler: answers, deaths, limits; what is wrong with it is one line."""

import pickle
import signal
import socket

import distributed
import pytest
from worker_tasks import cannot_be_sent, double, fails, mixed, surroundings

from pjpdaf.errors import BenchError, InfrastructureError
from scenarios.execute import cluster, cluster_worker, dask_client
from scenarios.execute.cluster import cluster_executor, worker_wait_s
from scenarios.execute.cluster_worker import Parcel, Sender, packed, perform
from scenarios.execute.place import Place
from scenarios.execute.software import OUR_CODE, PlugIns, software
from sim.processes import Answer, Lost


@pytest.fixture(scope="module")
def scheduler():
    """The address of a scheduler with a worker, both in this process."""
    options = {"processes": False, "protocol": "tcp://", "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, **options) as here:
        yield here.scheduler_address


@pytest.fixture(scope="module")
def pool(scheduler):
    with cluster_executor(Place(0, scheduler), PlugIns()) as executor:
        yield executor


def outcomes(executor, function, tasks, limit_s=60.0, **options):
    found = [pair for pair in executor.outcomes(function, tasks, limit_s, **options) if pair]
    assert len(found) == len(dict(found))
    return dict(found)


def test_answers_a_death_and_a_hang_arrive_once_each(pool):
    tasks = {7 * n: n for n in range(150)}
    found = outcomes(pool, mixed, tasks, limit_s=2.0, attempts=1)
    assert found.pop(7) == Lost(late=False, attempts=1, exit_code=-signal.SIGKILL)
    assert found.pop(14).late
    assert found == {7 * n: Answer(2 * n) for n in range(150) if n not in (1, 2)}


def test_what_a_task_raises_comes_out_and_the_rest_is_ended(pool):
    with pytest.raises(KeyError, match="one") as fault:
        outcomes(pool, fails, {n: n for n in range(4)})
    assert "In a worker:" in fault.value.__notes__[0]
    with pytest.raises((AttributeError, pickle.PicklingError), match="lambda"):
        outcomes(pool, cannot_be_sent, {0: 0})
    assert outcomes(pool, double, {0: 1}) == {0: Answer(2)}


def test_a_task_of_other_software_is_refused():
    ours = software(PlugIns())
    theirs = tuple({**ours, "numpy": "1.0"}.items())
    sender = pickle.dumps(Sender(theirs, PlugIns()))
    reply = perform(pickle.dumps(Parcel("r", "worker_tasks", packed(double, 1), sender, 9.0, 1, 0)))
    with pytest.raises(BenchError, match=rf"numpy {ours['numpy']}, here 1.0") as fault:
        cluster._outcome(reply, "tcp://w:1")
    assert str(fault.value).startswith("worker tcp://w:1 has other software than this process")
    assert OUR_CODE not in str(fault.value)


@pytest.mark.long
def test_processes_of_equal_software_start_with_the_module_of_their_task(monkeypatch):
    monkeypatch.setattr(cluster_worker, "_equal", set())
    sender = pickle.dumps(Sender(tuple(software(PlugIns()).items()), PlugIns()))
    module = "scenarios.run.merge"  # of ours, and loaded by nothing else here

    def loaded():
        """Whether a new isolated process has loaded it, unasked."""
        work = packed(surroundings, "modules")
        reply = perform(pickle.dumps(Parcel("r", module, work, sender, 60.0, 1, 0)))
        return module in cluster._outcome(reply).value

    cluster_worker._POOLS.close()
    assert not loaded()
    cluster_worker._POOLS.close()
    assert loaded()
    cluster_worker._POOLS.close()


def test_no_scheduler_and_no_worker_are_one_line(monkeypatch, capsys):
    monkeypatch.setattr(dask_client, "CONNECT_S", 1.0)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # nobody listens there
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(InfrastructureError, match=f"no Dask scheduler answers at {address}"):
            cluster_executor(Place(0, address), PlugIns()).__enter__()
    monkeypatch.setenv("PJPDAF_BENCH_WORKER_WAIT_S", "0.2")
    options = {"protocol": "tcp://", "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(n_workers=0, processes=False, **options) as empty:
        place = Place(0, empty.scheduler_address)
        with pytest.raises(InfrastructureError, match="no worker has joined") as fault:
            cluster_executor(place, PlugIns()).__enter__()
    assert f"start some: dask worker {place.scheduler}" in str(fault.value)
    assert "waiting for workers" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["0", "-1", "soon", "nan"])
def test_a_wait_that_is_none_is_refused(text):
    with pytest.raises(BenchError, match=r"PJPDAF_BENCH_WORKER_WAIT_S must be above 0"):
        worker_wait_s({"PJPDAF_BENCH_WORKER_WAIT_S": text})
