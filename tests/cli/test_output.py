"""What commands tell of the files that they write."""

import os

import pytest

from omnisim_cli.output import megabytes

pytestmark = pytest.mark.short


@pytest.mark.parametrize(("size", "told"), [(17_000, "0.017 MB"), (224_000, "0.22 MB"), (160_000_000, "160 MB")])
def test_sizes_are_told_in_two_digits_without_powers_of_ten(tmp_path, size, told):
    path = tmp_path / "file"
    path.touch()
    os.truncate(path, size)
    assert megabytes(path) == told
