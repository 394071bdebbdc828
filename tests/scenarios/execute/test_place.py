"""Where tasks are executed, as the command line says it."""

import pytest

from pjpdaf.errors import BenchError
from scenarios.execute.place import Place, place_of


def test_the_place_of_a_command():
    assert place_of(3, None) == Place(3)
    assert place_of(None, "local:2") == Place(2, "local")
    assert place_of(None, "tcp://host:8786") == Place(0, "tcp://host:8786")
    assert place_of(None, "tls://[::1]:8786").scheduler == "tls://[::1]:8786"
    assert str(Place(1)) == "1 worker"
    assert str(Place(2, "local")) == "a cluster of 2 workers here"


@pytest.mark.parametrize(
    ("jobs", "cluster", "line"),
    [
        (2, "local:2", "--jobs is for processes of this machine: leave it out with --cluster"),
        (None, "local:", "--cluster local:: must be local:N, as local:4"),
        (None, "local:0", "--cluster local:N must be between 1 and"),
        (None, "host:8786", "--cluster host:8786: must be the address of a Dask scheduler"),
        (None, "tcp://host", "--cluster tcp://host: must be the address"),
        (None, "http://host:80", "--cluster http://host:80: must be the address"),
    ],
)
def test_a_place_that_is_none_is_one_line(jobs, cluster, line):
    with pytest.raises(BenchError) as fault:
        place_of(jobs, cluster)
    assert str(fault.value).startswith(line)
    assert fault.value.exit_code == 2
