"""same.py A B PATH: that two trajectory files have the same datasets, PATH among them, of the same values."""

import sys

import h5py


def datasets(path):
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[...]} if isinstance(item, h5py.Dataset) else {}))
    return found


first, again = datasets(sys.argv[1]), datasets(sys.argv[2])
assert sys.argv[3] in first, f"no {sys.argv[3]}"
assert first.keys() == again.keys(), first.keys() ^ again.keys()
for name, values in first.items():
    assert values.tolist() == again[name].tolist() or values.tobytes() == again[name].tobytes(), name  # NaN in events
