#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Fits the coefficients of StepBelief to tables that `odometry_campaign --evidence` wrote.

Logistic models of features() (the same as in step_belief.cpp) give the probability that a step is
right within three of its own standard deviations, and the probability that it is off by less than
0.3 m and 1 degree, where no direction was left open. Two power laws, that is linear ones of the
logarithms, give how far off it is expected to be, in metres and in radians; they are fitted to all
errors, so steps that are right count as well.
Steps of methods other than NDT (method= in the case) have models of their own. With --output the
coefficients are written as step_belief.cpp includes them. With --check nothing is fitted: the
probabilities that the tables hold are compared with what is true, and --plot draws that as a
reliability diagram.
"""

import argparse
import csv

import numpy as np

# Name and smallest value of a column of which the logarithm is used; None: the value itself is used.
FEATURES = (
    ('sigma', 1e-4),
    ('sigma_angle', 1e-5),
    ('surprise', 1e-3),
    ('surprise_angle', 1e-4),
    ('surprise_sigmas', 1e-2),
    ('disagreement', 1e-3),
    ('disagreement_angle', 1e-4),
    ('disagreement_sigmas', 1e-2),
    ('overlap', None),
    ('pair_quality', None),
    ('points', 1.0),
    ('rescued', None),
    ('degenerate', None),
    ('residual_variance', 1e-2),
    ('sectors', None),
    ('unsteadiness', 1e-3),
    ('unsteadiness_angle', 1e-4),
    ('converged', None),
    ('sweep_gap', 1e-3),
    ('sweep_gap_angle', 1e-4),
    ('turn', 1e-3),
)
RIDGE = 1.0
# Errors below these differ by chance alone.
LEAST_ERROR = 1e-3  # m
LEAST_ERROR_DEG = 1e-2
WRONG_STEP = 0.3  # m
WRONG_STEP_DEG = 1.0
# As in step_belief.cpp.
COST_OF_SILENCE = 1.5
COST_OF_SILENCE_IN_DOUBT = 9.0
# Of a step of a chosen case beside one of a random mixture, to which the figures are to be true.
CHOSEN_WEIGHT = 0.3
EDGES = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0 + 1e-9)


def read(paths):
    """Columns of all tables by name, numbers as arrays. Lost scans claim nothing to be judged."""
    rows = []
    for path in paths:
        with open(path, newline='', encoding='utf-8') as file:
            rows += [row for row in csv.DictReader(file)
                     if None not in row.values() and row['state'] != 'lost']
    text = ('case', 'state')
    for row in rows:
        row.setdefault('degenerate', float(row['state'] == 'degenerate'))
    return {name: np.array([row[name] if name in text else float(row[name]) for row in rows])
            for name in rows[0]}


def features(table):
    """A row per step, the first column of ones."""
    columns = [np.ones(len(table['case']))]
    for name, least in FEATURES:
        value = table[name]
        columns.append(value if least is None else np.log10(np.maximum(value, least)))
    return np.stack(columns, axis=1)


def is_right(table):
    """Within three of its own standard deviations."""
    return ((table['error_m'] <= 3.0 * table['sigma']) &
            (np.radians(table['error_deg']) <= 3.0 * table['sigma_angle']))


def is_safe(table):
    """Not wrong, as odometry_campaign counts it."""
    return (table['error_m'] <= WRONG_STEP) & (table['error_deg'] <= WRONG_STEP_DEG)


def is_open(table):
    """The points left a direction open: that has a state of its own."""
    return table['degenerate'] > 0.0


def is_clean(table):
    """Steps of drives at full rate without faults."""
    return np.array(['fault=' not in case and 'every=' not in case for case in table['case']])


def is_sliding_window(table):
    """Steps of methods other than the sequential NDT."""
    return np.array(['method=' in case for case in table['case']])


def weights(table):
    """Random mixtures count in full."""
    return np.array([1.0 if case.startswith('random') else CHOSEN_WEIGHT
                     for case in table['case']])


def standardised(x):
    """Normalise all columns but the first to mean 0 and deviation 1; return them and the inverse for coefficients."""
    mean, scale = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-6)
    mean[0], scale[0] = 0.0, 1.0

    def undo(beta):
        result = beta / scale
        # A constant column has no information.
        result[1:][scale[1:] <= 1e-6] = 0.0
        result[0] -= (result * mean)[1:].sum()
        return result
    return (x - mean) / scale, undo


def fit(x, y, weight):
    """Coefficients for which the logistic function of x @ coefficients is the probability of y."""
    z, undo = standardised(x)
    beta = np.zeros(x.shape[1])
    for _ in range(50):
        p = probability(beta, z)
        hessian = (z * (weight * p * (1.0 - p))[:, None]).T @ z + RIDGE * np.eye(len(beta))
        step = np.linalg.solve(hessian, z.T @ (weight * (y - p)) - RIDGE * beta)
        beta += step
        if np.abs(step).max() < 1e-8:
            break
    return undo(beta)


def fit_error(x, error, weight):
    """Coefficients of the logarithm of the error."""
    z, undo = standardised(x)
    hessian = z.T @ (z * weight[:, None]) + RIDGE * np.eye(z.shape[1])
    return undo(np.linalg.solve(hessian, z.T @ (weight * np.log10(error))))


def fit_model(table):
    """Coefficients by the names of Weights in step_belief.cpp, in its order."""
    x, weight, closed = features(table), weights(table), ~is_open(table)
    errors = (np.maximum(table['error_m'], LEAST_ERROR),
              np.radians(np.maximum(table['error_deg'], LEAST_ERROR_DEG)))
    error, error_angle = (fit_error(x[closed], e[closed], weight[closed]) for e in errors)
    safe = fit(x[closed], is_safe(table)[closed].astype(float), weight[closed])
    return {'probability': fit(x, is_right(table).astype(float), weight), 'error': error,
            'error_angle': error_angle, 'safety': safe}


def safety(model, table):
    """Of each step, where no direction is open."""
    return probability(model['safety'], features(table))


def probability(coefficients, x):
    """Of each row."""
    return 1.0 / (1.0 + np.exp(-np.clip(x @ coefficients, -50.0, 50.0)))


def reliability(said, true):
    """Of bins of the figure: its mean, the share that is true, and how many there are."""
    rows = []
    for low, high in zip(EDGES, EDGES[1:]):
        inside = (said >= low) & (said < high)
        if inside.any():
            rows.append((said[inside].mean(), true[inside].mean(), int(inside.sum())))
    return rows


def report(title, said, true):
    """Brier score and reliability, in words."""
    share = true.mean()
    print(f'{title}: {len(true)} steps, {int((~true).sum())} not so; Brier score '
          f'{np.mean((said - true) ** 2):.4f} (of the mean share alone {share * (1 - share):.4f})')
    for mean, right, count in reliability(said, true):
        print(f'  said {mean:6.3f}  true {right:6.3f}  of {count}')


def draw(said, true, path):
    """Reliability diagram with the bins' numbers of steps."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    rows = np.array(reliability(said, true))
    error = np.sqrt(np.maximum(rows[:, 1] * (1.0 - rows[:, 1]), 0.01) / rows[:, 2])
    figure, axis = pyplot.subplots(figsize=(5.0, 5.0))
    axis.plot([0, 1], [0, 1], color='0.7', linewidth=1)
    axis.errorbar(rows[:, 0], rows[:, 1], yerr=error, marker='o', capsize=3)
    for mean, right, count in rows:
        axis.annotate(f'{int(count)}', (mean, right), textcoords='offset points', xytext=(6, -12),
                      fontsize=8)
    axis.set_xlabel('probability that the step is right, as reported')
    axis.set_ylabel('fraction of these steps that is right')
    axis.set_xlim(0, 1.02)
    axis.set_ylim(0, 1.02)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def as_code(name, model):
    """A constant of step_belief.cpp: a row per feature, a column per coefficient."""
    features_of_rows = ['1', *(feature for feature, _ in FEATURES)]
    rows = [f'    {{{", ".join(f"{c:8.4f}" for c in values)}}},  // {feature}\n'
            for feature, values in zip(features_of_rows, zip(*model.values()))]
    return f'constexpr Model {name} = {{{{\n{"".join(rows)}}}}};\n'


def doubted(table, safe):
    """Which steps are doubted, as DoubtState does it; rows are in the order of each drive."""
    result, case, in_doubt = np.zeros(len(safe), bool), None, False
    for i, (name, p, is_open_step) in enumerate(zip(table['case'], safe, is_open(table))):
        in_doubt = in_doubt and name == case
        case = name
        if not is_open_step:
            cost = COST_OF_SILENCE_IN_DOUBT if in_doubt else COST_OF_SILENCE
            in_doubt = result[i] = (1.0 - p) * cost > p
    return result


def report_states(table, said):
    """Wrong steps that are called tracked, and right ones of clean drives that are doubted."""
    wrong, clean = ~is_safe(table), is_clean(table)
    silent = int((wrong & ~said & ~is_open(table)).sum())
    alarms = int((clean & ~wrong & said & ~is_open(table)).sum())
    print(f'{int(wrong.sum())} wrong steps, {int((wrong & is_open(table)).sum())} degenerate, '
          f'{silent} of the others silent; {alarms} false alarms in {int(clean.sum())} steps '
          'without faults')


def check(table, plot):
    """Compare the predictions of the tables with the true errors."""
    report('right within three standard deviations', table['probability'], is_right(table))
    report_states(table, np.isin(table['state'], ('doubtful', 'degraded')))
    if plot:
        draw(table['probability'], is_right(table), plot)


def report_model(title, model, table):
    """How true it is of a table."""
    report(f'{title}, right', probability(model['probability'], features(table)), is_right(table))
    said = safety(model, table)
    closed = ~is_open(table)
    report(f'{title}, safe', said[closed], is_safe(table)[closed])
    report_states(table, doubted(table, said))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', maxsplit=1)[0])
    parser.add_argument('tables', nargs='+')
    parser.add_argument('--output', help='file to write the coefficients to')
    parser.add_argument('--check', action='store_true', help='fit nothing')
    parser.add_argument('--plot', help='picture to draw with --check')
    arguments = parser.parse_args()
    table = read(arguments.tables)
    if arguments.check:
        check(table, arguments.plot)
        return
    code = '// Written by scripts/fit_step_belief.py: see there.\n'
    for name, chosen in (('kNdtModel', ~is_sliding_window(table)),
                         ('kSlidingWindowModel', is_sliding_window(table))):
        part = {key: values[chosen] for key, values in table.items()}
        model = fit_model(part)
        report_model(name, model, part)
        code += as_code(name, model)
    if arguments.output:
        with open(arguments.output, 'w', encoding='utf-8') as file:
            file.write(code)


if __name__ == '__main__':
    main()
