"""The verbs of `scenarios`."""

from commands import ROOT, in_this_process

from scenarios.spec.names import scenario_names


def test_scenarios_list_show_validate_schema(tmp_path):
    def bench(*words):
        return in_this_process(*words)

    listed = bench("scenarios", "list").stdout
    for name in ("calm_table", "drink", "cross", "bounce", "speed_ladder", "smoke"):
        assert name in listed
    shown = bench("scenarios", "show", "cross", "--seed", "3").stdout
    assert "depth_gap" in shown
    assert "seed 3" in shown
    suite = bench("scenarios", "show", "core").stdout
    assert "digest: " in suite
    assert "drink+beard_glasses" in suite
    dim = bench("scenarios", "show", "cross", "--set", "light_gain=0.31").stdout
    assert "0.31" in dim
    good = bench("scenarios", "validate", *sorted((ROOT / "scenarios/catalog").glob("*.yaml")))
    assert good.returncode == 0
    assert good.stdout.count(": ok") == len(scenario_names())
    bad = tmp_path / "bad.yaml"
    bad.write_text("name: [")
    assert bench("scenarios", "validate", bad).returncode == 2
    assert '"properties"' in bench("scenarios", "schema").stdout
