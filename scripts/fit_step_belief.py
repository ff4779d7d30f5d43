#!/usr/bin/env python3
"""Fits the coefficients of StepBelief to tables that `odometry_campaign --evidence` wrote.

Two logistic models of the same figures (features(), the same as in step_belief.cpp), fitted by
Newton's method with a small ridge: that a step is right within three of its own standard
deviations, and that it is off by less than 0.3 m and 1 degree. Steps of methods other than NDT
(method= in the case) have models of their own. With --output the coefficients are written as
step_belief.cpp includes them. With --check nothing is fitted: the probabilities that the tables
hold are compared with what is true, and --plot draws that as a reliability diagram.
"""

import argparse
import csv

import numpy as np

# Name and least value of what counts by its logarithm; None: it counts as it is.
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
)
RIDGE = 1.0
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
    return (table['error_m'] <= 0.3) & (table['error_deg'] <= 1.0)


def is_sliding_window(table):
    """Steps of methods other than the sequential NDT."""
    return np.array(['method=' in case for case in table['case']])


def weights(table):
    """Random mixtures count in full."""
    return np.array([1.0 if case.startswith('random') else CHOSEN_WEIGHT
                     for case in table['case']])


def fit(x, y, weight):
    """Coefficients for which the logistic function of x @ coefficients is the probability of y."""
    mean, scale = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-6)
    mean[0], scale[0] = 0.0, 1.0
    z = (x - mean) / scale
    beta = np.zeros(x.shape[1])
    for _ in range(50):
        p = probability(beta, z)
        hessian = (z * (weight * p * (1.0 - p))[:, None]).T @ z + RIDGE * np.eye(len(beta))
        step = np.linalg.solve(hessian, z.T @ (weight * (y - p)) - RIDGE * beta)
        beta += step
        if np.abs(step).max() < 1e-8:
            break
    result = beta / scale
    result[0] -= (result * mean)[1:].sum()
    # What never varies says nothing.
    result[1:][x.std(axis=0)[1:] < 1e-6] = 0.0
    return result


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
    axis.set_xlabel('probability that the step is right, as said')
    axis.set_ylabel('share of these steps that is right')
    axis.set_xlim(0, 1.02)
    axis.set_ylim(0, 1.02)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def as_code(name, models):
    """A constant of step_belief.cpp."""
    rows = ['{' + ',\n      '.join(f'{c:.4f}' for c in model) + '}' for model in models]
    return f'constexpr Model {name}{{\n    {{' + '},\n    {'.join(rows) + '}};\n'


def check(table, plot):
    """What the tables say against what is true."""
    report('right within three standard deviations', table['probability'], is_right(table))
    wrong = ~is_safe(table)
    clean = np.array(['fault=' not in case for case in table['case']])
    silent = int((wrong & (table['state'] == 'tracking')).sum())
    alarms = int((clean & ~wrong & np.isin(table['state'], ('doubtful', 'degraded'))).sum())
    print(f'{int(wrong.sum())} wrong steps, {silent} of them tracking; {alarms} of '
          f'{int(clean.sum())} steps without faults are doubtful or degraded and not wrong')
    if plot:
        draw(table['probability'], is_right(table), plot)


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
        models = []
        for title, true in (('right', is_right(part)), ('safe', is_safe(part))):
            x = features(part)
            models.append(fit(x, true.astype(float), weights(part)))
            report(f'{name}, {title}', probability(models[-1], x), true)
        code += as_code(name, models)
    if arguments.output:
        with open(arguments.output, 'w', encoding='utf-8') as file:
            file.write(code)


if __name__ == '__main__':
    main()
