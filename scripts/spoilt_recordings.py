#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Spoils a simulated recording in the ways in which real ones are spoilt, maps each with the
defaults and says whether the map is good or the user was told what is wrong.

    scripts/spoilt_recordings.py --output /tmp/spoilt
    scripts/spoilt_recordings.py --output /tmp/spoilt --only times_ gnss_frozen

A result that is in the output folder already is kept: delete results.jsonl for new ones. Verdicts:
    good    the map is as exact as that of the clean recording, and nothing was said
    alarm   the map is as exact, and something was said: its text shows whether rightly
    named   the map is worse or missing, and check_bag or map_bag said something: read what
    SILENT  the map is worse, and nothing was said
    CRASH   a program was ended by a signal
"""
import argparse
import json
import os
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from recording_faults import all_kinds  # noqa: E402, F401
from recording_faults.examination import examine, simulate  # noqa: E402
from recording_faults.records import read_records  # noqa: E402
from recording_faults.variants import VARIANTS  # noqa: E402
from recording_faults.verdicts import counts, judge, reference_error, table, text_of  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", required=True, help="folder for bags and results")
    parser.add_argument("--only", nargs="*", help="names of variants, or their beginnings")
    parser.add_argument("--keep", action="store_true", help="keep the spoilt bags")
    parser.add_argument("--table", action="store_true", help="print the results that are there")
    return parser.parse_args()


def earlier_results(path):
    if not os.path.exists(path):
        return []
    with open(path) as lines:
        return [json.loads(line) for line in lines]


def chosen_names(beginnings):
    return [name for name in VARIANTS if not beginnings or name.startswith(tuple(beginnings))]


def examine_all(options, path):
    """Examines the chosen variants that have no result yet; adds their results to the file."""
    os.makedirs(options.output, exist_ok=True)
    options.clean = options.output + "/clean.bag"
    options.truth = options.output + "/clean.tum"
    if not os.path.exists(options.clean):
        simulate(options.clean, options.truth)
    clean = read_records(options.clean)
    results = earlier_results(path)
    known = {result["name"] for result in results}
    with open(path, "a") as out:
        for name in chosen_names(options.only):
            if name in known:
                continue
            try:
                result = examine(name, options, clean)
            except Exception as error:
                print("\n== ", name, "could not be made:", repr(error), flush=True)
                continue
            results.append(result)
            result["verdict"] = judge(result, reference_error(results, result["sensors"]))
            out.write(json.dumps(result) + "\n")
            out.flush()
            print(text_of(result), flush=True)


def main():
    options = arguments()
    path = options.output + "/results.jsonl"
    if options.table:
        results = earlier_results(path)
        print(table(results), counts(results), sep="\n\n")
    else:
        examine_all(options, path)


if __name__ == "__main__":
    main()
