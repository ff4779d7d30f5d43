# SPDX-License-Identifier: BSD-3-Clause
"""The variants of the recording, and the decorators that make functions into variants."""

VARIANTS = {}


class Variant:
    """A way in which the recording is spoilt.

    make(records) changes the list of records of its sensors and returns it. With `beside_clean`, it
    is make(records, clean), where `clean` are all records of the clean recording. With `of_files`,
    it is make(clean, folder): it gets the path of the clean bag and returns the paths of the input.
    `truth_shift` (s) is added to the stamps of the truth before the map is compared with it.
    """

    def __init__(self, make, sensors, truth_shift=0.0, beside_clean=False, of_files=False):
        self.make, self.sensors, self.truth_shift = make, sensors, truth_shift
        self.beside_clean, self.of_files = beside_clean, of_files

    @property
    def kind(self):
        """The kind of fault: the name of the file in which the variant is."""
        return self.make.__module__.rpartition(".")[2]

    def spoilt(self, records, clean):
        return self.make(records, clean) if self.beside_clean else self.make(records)


def add(variant_):
    name = variant_.make.__name__
    if name in VARIANTS:
        raise ValueError(f"{name}: there are two variants of this name; rename one of them")
    VARIANTS[name] = variant_
    return variant_.make


def variant(sensors, truth_shift=0.0, beside_clean=False):
    """Decorates a function that changes records of these sensors (a key of records.SENSORS)."""
    return lambda make: add(Variant(make, sensors, truth_shift, beside_clean))


def variant_of_files(make):
    """Decorates a function that makes files from the clean bag."""
    return add(Variant(make, "all", of_files=True))
