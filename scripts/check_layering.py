#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Hold the includes against the table of stages: a file includes only its own stage and those below.

doc/architecture.md shows this table, and a picture of it; draw_layers.py writes both.
usage: check_layering.py [ROOT]
"""
import pathlib
import re
import sys

CONFIGURED = {'common', 'config'}
MATCHING = CONFIGURED | {'registration'}
CORE = {'common', 'config', 'preprocessing', 'registration', 'front_end', 'loop_closing',
        'back_end', 'map', 'session', 'evaluation', 'simulation'}
# From the ground up: what a stage is, and the stages that it may include.
STAGES = {
    'common': ('time, poses, point clouds, covariances, units, voxel keys, errors', set()),
    'config': ('fields, YAML files, checks', {'common'}),
    'registration': ('Gaussian voxel maps, NDT, VGICP and the methods of PCL', CONFIGURED),
    'front_end': ('odometry: pose of each scan, key frames', MATCHING),
    'loop_closing': ('candidates for loops and their verification', MATCHING),
    'preprocessing': ('synchronisation, deskewing, filters, GNSS in local axes, floor', CONFIGURED),
    'back_end': ('pose graph: factors, solvers, robust kernels, g2o files', CONFIGURED),
    'map': ('maps and their files, moving objects, quality', CONFIGURED),
    'session': ('what is kept of a drive on disk', CONFIGURED),
    'simulation': ('worlds, sensors and drives', CONFIGURED),
    'evaluation': ('errors of trajectories against the truth', {'common'}),
    'pipeline': ('the stages put together, without ROS', CORE),
    'ros': ('messages and values, bags, parameters, queues', CORE | {'pipeline'}),
    'nodes': ('one file for each node', CORE | {'pipeline', 'ros'}),
    'tools': ('one file for each command', CORE | {'pipeline', 'ros'}),
}
ALLOWED = {stage: allowed for stage, (_, allowed) in STAGES.items()}
ROS_STAGES = {'ros', 'nodes', 'tools'}
OWN_INCLUDE = re.compile(r'^\s*#\s*include\s*"lidar_mapping/(\w+)/')
ROS_INCLUDE = re.compile(
    r'^\s*#\s*include\s*[<"](ros|rosbag|tf2|tf2_\w+|\w+_msgs|diagnostic_updater|XmlRpc\w*|'
    r'lidar_mapping/[A-Z]\w*\.h)\b')


def stage_of(path, root):
    parts = path.relative_to(root).parts
    return parts[2] if parts[0] == 'include' else parts[1]


def problems_of(path, root):
    stage = stage_of(path, root)
    name = path.relative_to(root)
    if stage not in ALLOWED:
        yield f'{name}: {stage} is no stage of the layering table'
        return
    for number, line in enumerate(path.read_text().splitlines(), 1):
        own = OWN_INCLUDE.match(line)
        if own and own.group(1) != stage and own.group(1) not in ALLOWED[stage]:
            yield f'{name}:{number}: {stage} may not include {own.group(1)}'
        if stage not in ROS_STAGES and ROS_INCLUDE.match(line):
            yield f'{name}:{number}: {stage} may not know ROS: {line.strip()}'


def main(root):
    files = [path for folder in ('include/lidar_mapping', 'src')
             for pattern in ('*.hpp', '*.cpp') for path in (root / folder).rglob(pattern)]
    problems = [problem for path in sorted(files) for problem in problems_of(path, root)]
    print('\n'.join(problems + [f'layering: {len(files)} files, {len(problems)} problems']))
    return 1 if problems or not files else 0


if __name__ == '__main__':
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else default))
