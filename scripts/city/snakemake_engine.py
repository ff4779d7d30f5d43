# SPDX-License-Identifier: BSD-3-Clause
"""Runs the jobs of a city by Snakemake, on this machine or on a cluster."""
import pathlib
import re
import shutil
import subprocess

from city.project import ProjectError

FOLDER = pathlib.Path(__file__).resolve().parent
SLURM_PROFILES = {7: 'slurm', 8: 'slurm8'}


def is_installed():
    return shutil.which('snakemake') is not None


def major_version():
    text = subprocess.run(['snakemake', '--version'], capture_output=True, text=True, check=True).stdout
    return int(re.match(r'(\d+)', text).group(1))


def cluster_arguments(cluster):
    """`slurm`, the folder of a profile, or a command that submits a job script."""
    if cluster is None:
        return []
    if cluster == 'slurm':
        version = 8 if major_version() >= 8 else 7
        return ['--profile', str(FOLDER / 'profiles' / SLURM_PROFILES[version])]
    if pathlib.Path(cluster).is_dir():
        return ['--profile', cluster]
    if major_version() >= 8:
        raise ProjectError(f'--cluster: {cluster!r}: Snakemake 8 takes no command; name the folder of a profile with an '
                           'executor plugin')
    return ['--cluster', cluster, '--latency-wait', '60']


def run(city, command, cluster, workers):
    """Runs what is not done; the exit status of Snakemake."""
    city.forget_unsettled()
    words = ['snakemake', '--snakefile', str(FOLDER / 'Snakefile'), '--directory', str(city.output),
             '--config', f'project={city.project.path}', f'command={command}', '--keep-going', '--rerun-incomplete',
             # map_city has a lock of its own, which ends with its process.
             '--nolock', '--rerun-triggers', 'mtime', '--printshellcmds']
    words += cluster_arguments(cluster)
    words += ['--jobs', str(workers)] if cluster else ['--cores', str(workers)]
    return subprocess.run(words).returncode
