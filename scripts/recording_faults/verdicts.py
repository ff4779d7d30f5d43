# SPDX-License-Identifier: BSD-3-Clause
"""Verdicts on what the programs made of the variants, and tables of them."""
from recording_faults.variants import VARIANTS

VERDICTS = ("good", "alarm", "named", "SILENT", "CRASH")
# A map is as good as that of the clean recording up to this ratio of their errors, and this many
# metres beyond. Chosen: the noise of points is 2 cm, and what a user sees begins at some cm.
GOOD_RATIO = 3.0
GOOD_ERROR_M = 0.03
GOOD_COVERAGE = 0.9  # of the drive's time that has key frames; chosen
# m, in the place of the error of a clean recording that was not examined. Chosen: well above those
# that were measured (2 to 4 mm), so that a variant that is examined alone is not blamed for noise.
UNKNOWN_REFERENCE_M = 0.02
ALARMS = ("FAULT", "WARNING", "warning", "error", "cannot", "no transform", "refused", "dropped",
          "is it another clock", "left out", "Noticed", "doubt", "does not agree", "do not agree",
          "without times", "run backwards")


def alarms(lines):
    """The lines of a program in which something is reported."""
    return [line.strip() for line in lines if any(word in line for word in ALARMS)]


def reference_error(results, sensors):
    """The error (m) of the clean recording of these sensors, if it is among the results."""
    for result in results:
        if result["name"] == sensors + "_clean":
            return result["ape"] or 0.0
    return UNKNOWN_REFERENCE_M


def judge(result, reference):
    """One of VERDICTS, for a clean recording with this error (m)."""
    if min(result["check_status"], result["map_status"]) < 0:
        return "CRASH"
    said = result["check_status"] != 0 or result["map_status"] != 0 or alarms(result["map_bag"])
    good = (result["ape"] is not None and result["coverage"] >= GOOD_COVERAGE and
            result["ape"] <= GOOD_RATIO * reference + GOOD_ERROR_M)
    return ("alarm" if said else "good") if good else ("named" if said else "SILENT")


def millimetres(ape, missing):
    return missing if ape is None else f"{1e3 * ape:.1f}"


def text_of(result):
    """A result for people: the verdict, and all that was said."""
    unit = "" if result["ape"] is None else " mm"
    return "\n".join([
        f"\n== {result['name']} ({result['sensors']}): {result['verdict']}, "
        f"APE {millimetres(result['ape'], '-')}{unit}, "
        f"{100 * result['coverage']:.0f} % of the time",
        "\n  ".join([f"check_bag: {result['check_status']}"] + result["check_bag"]),
        "\n  ".join([f"map_bag: {result['map_status']}"] + result["map_bag"])])


def markdown(head, rows):
    lines = [head, ["---"] * len(head)] + rows
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def table(results):
    """The results as a table in Markdown."""
    return markdown(["variant", "sensors", "APE, mm", "verdict"], [
        [f"`{result['name']}`", result["sensors"], millimetres(result["ape"], ""),
         result["verdict"]] for result in results])


def counts(results):
    """How often each kind of fault got each verdict; the sums are in the last row."""
    kinds = {}
    for result in results:
        known = VARIANTS.get(result["name"])
        kind = known.kind if known else "no longer there"
        kinds.setdefault(kind, []).append(result["verdict"])
    kinds["all"] = [result["verdict"] for result in results]
    return markdown(["kind", "variants", *VERDICTS], [
        [kind, len(given)] + [given.count(verdict) for verdict in VERDICTS]
        for kind, given in kinds.items()])
