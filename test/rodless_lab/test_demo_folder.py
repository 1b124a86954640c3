"""The demo removes the bag of an earlier demo, and nothing else."""

from pathlib import Path

import pytest

from rodless_lab.demo import remove_old_bag
from rodless_lab.session.errors import HarnessError


def test_files_that_are_no_bag_are_kept(tmp_path: Path) -> None:
    """A folder with somebody's file is refused by name and stays as it is."""
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "notes.txt").write_text("precious", encoding="utf-8")
    with pytest.raises(HarnessError, match="not the bag of a demo; choose another --output"):
        remove_old_bag(bag)
    assert (bag / "notes.txt").read_text(encoding="utf-8") == "precious"


def test_an_earlier_bag_is_removed(tmp_path: Path) -> None:
    """A bag's own files go, and a bag that is not there is no fault."""
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "bag_0.mcap").touch()
    (bag / "metadata.yaml").touch()
    remove_old_bag(bag)
    remove_old_bag(bag)
    assert not bag.exists()
