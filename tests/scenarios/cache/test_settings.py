from pathlib import Path

import pytest

from pjpdaf.errors import BenchError
from scenarios.cache.settings import CacheSettings, cache_settings


def test_folder_and_size_of_the_environment():
    home = str(Path.home())
    assert cache_settings({"HOME": home}) == CacheSettings(
        Path(home) / ".cache" / "pjpdaf-bench", 5_000_000_000
    )
    found = cache_settings({"XDG_CACHE_HOME": "/c", "PJPDAF_BENCH_CACHE_GB": "0.5"})
    assert found == CacheSettings(Path("/c/pjpdaf-bench"), 500_000_000)
    named = cache_settings({"XDG_CACHE_HOME": "/c", "PJPDAF_BENCH_CACHE": "/d"})
    assert named == CacheSettings(Path("/d"), 5_000_000_000)
    assert cache_settings({"PJPDAF_BENCH_CACHE": "off"}) is None
    assert cache_settings({"XDG_CACHE_HOME": "relative"}) == cache_settings({})


@pytest.mark.parametrize("size", ["0", "-1", "nan", "much", "1e9"])
def test_a_size_that_is_none(size):
    with pytest.raises(BenchError, match="PJPDAF_BENCH_CACHE_GB must be above 0"):
        cache_settings({"PJPDAF_BENCH_CACHE_GB": size})
