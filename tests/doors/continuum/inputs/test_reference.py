"""The reference of inputs says what the models check; templates are inputs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import atomistic.front.cli
import continuum.front.cli
from atomistic.inputs.crystal import ElasticConfig
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.validate import ValidateConfig
from continuum.inputs.reading import load
from continuum.inputs.reference import entries, markdown, schema, template
from continuum.inputs.toml import Document
from continuum.store.runs.config import RunConfig

EXAMPLES: dict[type[Document], str] = {
    RunConfig: "inputs/smoke/path.toml",
    ValidateConfig: "inputs/validate/quick.toml",
    DeckConfig: "inputs/lammps/rough.toml",
}


@pytest.mark.parametrize("model", [*EXAMPLES, ElasticConfig])
def test_every_key_has_a_type_and_a_meaning(model: type[Document]) -> None:
    page = markdown(model, "Keys")
    for table in entries(model):
        for key in table.keys:
            assert f"| `{key.name}` | " in page
            assert key.type
            # A key of fixed names says itself which kind of table it is.
            assert key.meaning or key.type.startswith('"'), (table.place, key.name)
    assert json.loads(schema(model))["title"] == model.__name__


def test_a_pair_is_told_from_a_list_in_whose_place_one_number_may_be_given() -> None:
    types = {(table.kind or table.place, key.name): key.type for table in entries(RunConfig) for key in table.keys}
    assert types["[grid]", "n"] == "whole number, or list of 2 whole numbers, >= 1, <= 65536"
    assert types["[grid]", "period"] == "number, or list of 2 numbers, >= 1, <= 65536"
    allowed = json.loads(schema(RunConfig))["$defs"]["GridTable"]["properties"]["n"]["anyOf"]
    assert [each["type"] for each in allowed] == ["integer", "array"]
    assert types['kind = "sine"', "waves"] == "list of 2 whole numbers, >= -65536, <= 65536"


@pytest.mark.parametrize("model", EXAMPLES)
def test_a_template_is_the_example_with_every_key_described(model: type[Document], tmp_path: Path) -> None:
    text = template(model, EXAMPLES[model])
    (tmp_path / "mine.toml").write_text(text)
    mine, example = load(tmp_path / "mine.toml", model), load(Path(EXAMPLES[model]), model)
    assert mine.plain(identity=True) == example.plain(identity=True)
    assert max(map(len, text.splitlines())) <= 120


@pytest.mark.parametrize(
    ("main", "kinds"), [(continuum.front.cli.main, ["run"]), (atomistic.front.cli.main, ["validate", "deck"])]
)
def test_the_commands_print_them(main, kinds: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for kind in kinds:
        assert main(["init", kind]) == 0
        (tmp_path / f"{kind}.toml").write_text(capsys.readouterr().out)
        assert main(["schema", kind]) == 0
        assert json.loads(capsys.readouterr().out)["properties"]
    if "run" in kinds:
        assert main(["check", str(tmp_path / "run.toml")]) == 0
