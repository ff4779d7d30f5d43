#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Hold the includes against the table of stages: a file includes only its own stage and those below.

A stage without a folder in include/lidar_mapping is a room: programs share it, and nobody else may use it.

doc/architecture.md shows this table, and a picture of it; draw_layers.py writes both.
usage: check_layering.py [ROOT]
"""
import pathlib
import re
import sys

CONFIGURED = {'common', 'config'}
MATCHING = CONFIGURED | {'registration'}
DRIVING = MATCHING | {'front_end', 'preprocessing'}
MAPPING = DRIVING | {'loop_closing', 'pose_graph', 'back_end', 'session'}
# From the bottom to the top: purpose of a stage, and the stages that it may include.
STAGES = {
    'common': ('time, poses, point clouds, covariances, units, voxel keys, errors', set()),
    'config': ('fields, YAML files, checks', {'common'}),
    'registration': ('Gaussian voxel maps, NDT, VGICP and the methods of PCL', CONFIGURED),
    'front_end': ('odometry: pose of each scan, key frames', MATCHING),
    'loop_closing': ('candidates for loops and their verification', MATCHING),
    'localization': ('a drive found and followed in a finished map', MATCHING | {'loop_closing'}),
    'preprocessing': ('synchronisation, deskewing, filters, GNSS in local axes, floor', CONFIGURED),
    'pose_graph': ('any pose graph: factors, robust kernels, solvers, g2o files', {'common'}),
    'back_end': ('the graph of a drive: odometry, loops, GNSS, IMU, floor', CONFIGURED | {'pose_graph'}),
    'moving_objects': ('ground, and what passed through the map, by visibility', {'common'}),
    'json': ('figures as JSON text', set()),
    'map': ('maps and their files', CONFIGURED | {'moving_objects', 'json'}),
    'map_quality': ('thickness, residual misalignment between passes, entropy', {'common'}),
    'session': ('what is kept of a drive on disk', CONFIGURED),
    'simulation': ('worlds, sensors and drives', CONFIGURED),
    'evaluation': ('errors of trajectories against the truth', {'common'}),
    'pipeline': ('the stages put together, without ROS', MAPPING | {'localization'}),
    'map_import': ('maps from elsewhere made into sessions', CONFIGURED | {'session'}),
    'city': ('many drives: pairs, loops between drives, one graph', MAPPING | {'pipeline', 'json'}),
    'report': ('figures and verdicts of a map, and the record of its making',
               MAPPING | {'localization', 'pipeline', 'moving_objects', 'map', 'map_quality', 'evaluation',
                          'json'}),
    'campaign': ('odometry over many simulated cases, checked step by step',
                 DRIVING | {'simulation', 'evaluation', 'json'}),
    'ros': ('messages and values, bags, parameters, queues', DRIVING | {'json'}),
    'recordings': ('a drive from bags or folders', MAPPING | {'pipeline', 'ros'}),
    'nodes': ('one file for each node',
              MAPPING | {'localization', 'pipeline', 'moving_objects', 'map', 'json', 'ros'}),
    'tools': ('one file for each command',
              MAPPING | {'localization', 'pipeline', 'moving_objects', 'map', 'map_quality', 'simulation', 'evaluation',
                         'json', 'map_import', 'city', 'report', 'campaign', 'ros', 'recordings'}),
}
ALLOWED = {stage: allowed for stage, (_, allowed) in STAGES.items()}
ROS_STAGES = {'ros', 'recordings', 'nodes', 'tools'}
OWN_INCLUDE = re.compile(r'^\s*#\s*include\s*"lidar_mapping/(\w+)/')
PLAIN_INCLUDE = re.compile(r'^\s*#\s*include\s*"((?!lidar_mapping/)[^"]+)"')
ROS_INCLUDE = re.compile(
    r'^\s*#\s*include\s*[<"](ros|rosbag|tf2|tf2_\w+|\w+_msgs|diagnostic_updater|XmlRpc\w*|'
    r'lidar_mapping/[A-Z]\w*\.h)\b')


def stage_of(path, root):
    parts = path.relative_to(root).parts
    return parts[2] if parts[0] == 'include' else parts[1]


def is_beside(header, stage, root):
    """A header beside the sources is for its own stage; one of a room, which has no other, for its users too."""
    rooms = [other for other in ALLOWED[stage] if not (root / 'include/lidar_mapping' / other).is_dir()]
    return any((root / 'src' / folder / header).is_file() for folder in [stage] + rooms)


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
        plain = PLAIN_INCLUDE.match(line)
        if plain and not is_beside(plain.group(1), stage, root):
            yield f'{name}:{number}: {plain.group(1)} lies neither in src/{stage} nor in a room that {stage} may use'
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
