#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds scripts/map_city with commands that take no time: which jobs run, what is done again, bad recordings,
kills at any moment, and the same through Snakemake where that is installed."""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parents[1] / 'scripts'))
from city.jobs import City  # noqa: E402
from city.project import read_project  # noqa: E402
from city.run_job import aside  # noqa: E402
from toy_programs import products_of, write_programs, write_project  # noqa: E402

MAP_CITY = HERE.parents[1] / 'scripts' / 'map_city'
THREE = {'a': 'good 1', 'b': 'good 2', 'c': 'good 3'}


class MapCityTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.programs = write_programs(self.folder / 'programs')
        self.environment = {**os.environ, 'TOY_LOG': str(self.folder / 'log'), 'HOME': str(self.folder)}

    def words(self, project, *options):
        return ['/usr/bin/python3', str(MAP_CITY), str(project), '--programs', str(self.programs), *options]

    def run_city(self, project, *options, engine='--local', **environment):
        words = self.words(project, *options, *([engine] if engine else []))
        return subprocess.run(words, env={**self.environment, **environment}, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)

    def commands(self):
        """Commands that have run since the last call."""
        log = self.folder / 'log'
        lines = log.read_text().splitlines() if log.exists() else []
        log.write_text('')
        return lines

    def city(self, name, recordings, *options, **environment):
        """A city that is there; the folder of its output."""
        project = write_project(self.folder / name, recordings)
        done = self.run_city(project, *options, **environment)
        self.assertEqual(done.returncode, 0, done.stdout)
        return self.folder / name / 'out'


class Graph(MapCityTest):
    def test_every_stage_runs_once(self):
        output = self.city('one', THREE)
        programs = [line.split()[0] if line.split()[0] != 'join_drives' else line.split()[1] for line in self.commands()]
        self.assertEqual({name: programs.count(name) for name in set(programs)},
                         {'check_bag': 3, 'map_bag': 3, 'describe': 3, 'map_quality': 4, 'pairs': 1, 'loops': 2,
                          'graph': 1, 'build_map': 1})
        self.assertIn('drives/a/report.html', (output / 'report.html').read_text())
        self.assertFalse(list(output.rglob('.part/*')))

    def test_nothing_is_done_twice(self):
        self.city('one', THREE)
        self.commands()
        self.city('one', THREE)
        self.assertEqual([line for line in self.commands()], [])

    def test_a_drive_that_changed_is_mapped_again_and_its_chunks(self):
        self.city('one', THREE)
        self.commands()
        self.city('one', {**THREE, 'c': 'good but longer'})
        commands = ' '.join(self.commands())
        self.assertIn('bags/c.bag', commands)
        self.assertNotIn('map_bag ' + str(self.folder / 'one/bags/a.bag'), commands)
        self.assertIn('b--c--000', commands)
        self.assertNotIn('a--b--000', commands)

    def test_other_products_need_no_other_graph(self):
        self.city('one', THREE)
        self.commands()
        project = write_project(self.folder / 'one', THREE, 'map: {formats: [las]}\n')
        self.assertEqual(self.run_city(project).returncode, 0)
        self.assertEqual([line.split()[0] for line in self.commands()], ['build_map', 'map_quality'])

    def test_the_number_of_jobs_changes_no_byte(self):
        many = {f'd{number:02d}': f'good {number}' for number in range(8)}
        self.assertEqual(products_of(self.city('one', many)), products_of(self.city('two', many, '--jobs', '4')))

    def test_dry_run_and_status_do_nothing(self):
        project = write_project(self.folder / 'one', THREE)
        self.assertIn('map/a', self.run_city(project, '--dry-run').stdout)
        self.assertIn('waiting', self.run_city(project, '--status').stdout)
        self.assertEqual(self.commands(), [])
        self.assertFalse((self.folder / 'one/out').exists())

    def test_a_namesake_renames_no_drive_that_is_mapped(self):
        def project(*days):
            for day in days:
                (self.folder / day).mkdir(exist_ok=True)
                if not (self.folder / day / 'run.bag').exists():
                    (self.folder / day / 'run.bag').write_text(f'good {day}')
            path = self.folder / 'project.yaml'
            path.write_text('output: out\nrecordings:\n' + ''.join(f'  - path: {day}/run.bag\n' for day in days))
            return path
        self.assertEqual(self.run_city(project('monday')).returncode, 0)
        self.commands()
        self.assertEqual(self.run_city(project('tuesday', 'monday')).returncode, 0)
        self.assertNotIn('monday/run.bag', ' '.join(self.commands()))
        sessions = {name: (self.folder / 'out/drives' / name / 'session').read_text() for name in ('run', 'tuesday_run')}
        self.assertIn('good monday', sessions['run'])
        self.assertIn('good tuesday', sessions['tuesday_run'])

    def test_a_drive_that_is_gone_takes_its_chunks_along(self):
        self.city('one', THREE)
        (self.folder / 'one/bags/c.bag').unlink()
        project = self.folder / 'one/project.yaml'
        status, plan = (self.run_city(project, option).stdout for option in ('--status', '--dry-run'))
        self.assertNotIn('b--c', status + plan)
        self.assertIn('all chunks of the loop search are known when the pairs are', status)
        self.assertIn('loops/... (known when the pairs are)', plan)
        ended = self.run_city(write_project(self.folder / 'one', {'b': 'killed'}))
        self.assertEqual(ended.returncode, 3, ended.stdout)
        self.assertIn('start it again to go on', ended.stdout)

    def test_mistakes_are_one_line(self):
        done = self.run_city(self.folder / 'none.yaml')
        self.assertEqual((done.returncode, done.stdout.count('\n')), (1, 1))
        project = write_project(self.folder / 'one', THREE)
        for options in (('--jobs', '0'), ('--job', 'map/zebra'), ('--programs', '/nowhere')):
            done = self.run_city(project, *options)
            self.assertEqual((done.returncode, done.stdout.count('\n')), (1, 1), done.stdout)


class ForeignFiles(MapCityTest):
    def test_they_stay_where_they_are(self):
        project = write_project(self.folder / 'one', THREE)
        bag, precious = (self.folder / 'one' / name for name in ('drives/day1/p1.bag', 'products/precious.txt'))
        for file in (bag, precious):
            file.parent.mkdir(parents=True)
            file.write_text('good')
        project.write_text('recordings: [{path: drives/day1}]\noutput: .\n')
        done = self.run_city(project)
        self.assertEqual((done.returncode, done.stdout.count('\n')), (1, 1), done.stdout)
        self.assertTrue(bag.exists() and precious.exists())

    def test_a_report_marks_the_folder_as_a_city(self):
        project = write_project(self.folder / 'one', THREE)
        self.assertEqual(self.run_city(project, '--report').returncode, 0)
        self.assertEqual(self.run_city(project).returncode, 0)


class Aside(MapCityTest):
    def test_what_is_replaced_is_in_nobodys_way(self):
        day, other = self.folder / 'day', self.folder / 'day.old'
        day.mkdir()
        with aside(other) as part:
            part.mkdir()
            with aside(day) as new:
                new.mkdir()
            self.assertTrue(part.exists(), 'the other drive is still being mapped')
        self.assertTrue(day.exists() and other.exists())


class DoneFiles(MapCityTest):
    """What Snakemake takes for done."""
    def done_after(self, change, more=''):
        output = self.city('one', THREE)
        change(self.folder / 'one/bags')
        city = City(read_project(write_project(self.folder / 'one', {}, more)))
        city.forget_unsettled()
        return sorted(str(file.relative_to(output / 'jobs'))[:-5] for file in output.glob('jobs/*/*.done'))

    def test_they_hold_the_key(self):
        output = self.city('one', THREE)
        for job in ('map/a', 'report/city'):
            self.assertIn((output / f'jobs/{job}.done').read_text().strip(), (output / f'jobs/{job}.json').read_text())

    def test_those_of_a_city_that_is_done_stay(self):
        self.assertEqual(len(self.done_after(lambda bags: None)), 3 + 3 + 1 + 2 + 3)

    def test_that_of_a_changed_drive_goes_with_all_behind_it(self):
        self.assertEqual(self.done_after(lambda bags: (bags / 'c.bag').write_text('good but longer')),
                         ['check/a', 'check/b', 'map/a', 'map/b'])

    def test_those_of_a_drive_that_is_gone_go(self):
        self.assertEqual(self.done_after(lambda bags: (bags / 'c.bag').unlink()), ['check/a', 'check/b', 'map/a', 'map/b'])

    def test_other_settings_count(self):
        before_join = self.done_after(lambda bags: None, 'datum: [49, 8, 100]\n')
        self.assertEqual([job for job in before_join if not job.startswith(('check/', 'map/'))],
                         ['loops/a--b--000', 'loops/b--c--000', 'pairs/city'])


class BadRecordings(MapCityTest):
    BAD = {**THREE, 'd': 'empty', 'e': 'crash', 'f': 'unreadable'}

    def test_they_do_not_stop_the_others_and_are_named(self):
        project = write_project(self.folder / 'bad', self.BAD)
        done = self.run_city(project)
        self.assertEqual(done.returncode, 4, done.stdout)
        page = (self.folder / 'bad/out/report.html').read_text()
        for text in ('d: failed: map_bag: no scan could be used', 'e: failed: map_bag ended with signal 11',
                     'f: refused: check_bag: this is no bag'):
            self.assertIn(text, done.stdout)
            self.assertIn(text.split(': ', 2)[2], page)
        good = {name: content for name, content in products_of(self.folder / 'bad/out').items() if name != 'report.json'}
        alone = products_of(self.city('good', THREE))
        alone.pop('report.json')
        self.assertEqual(good, alone)

    def test_they_are_not_tried_again_unless_asked(self):
        project = write_project(self.folder / 'bad', self.BAD)
        self.run_city(project)
        self.commands()
        self.assertEqual(self.run_city(project).returncode, 4)
        self.assertEqual(self.commands(), [])
        self.run_city(project, '--retry-failed')
        self.assertEqual(sum(line.startswith('map_bag') for line in self.commands()), 2)

    def test_no_good_recording_is_no_city(self):
        project = write_project(self.folder / 'bad', {'d': 'empty'})
        done = self.run_city(project)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn('no drive could be mapped', done.stdout)

    def test_doubt_is_named(self):
        done = self.run_city(write_project(self.folder / 'bad', {**THREE, 'd': 'doubtful'}))
        self.assertEqual(done.returncode, 4)
        self.assertIn('d: joined: parts of its own map cannot be trusted', done.stdout)

    def test_all_faults_of_the_input_are_named_and_nothing_else(self):
        output = self.city('bad', {'a': 'good', 'f': 'faulty'})
        expected = []
        for sensor in ('imu', 'gnss'):
            expected.append(f'{sensor:<10}/{sensor}: 100 Hz')
            for number in range(3):
                expected += [f'FAULT   {sensor} {number} is wrong', f'remedy: mend {number}']
        drives = json.loads((output / 'report.json').read_text())['drives']
        self.assertEqual([drive['faults'] for drive in drives], [[], expected])
        for line in expected:
            self.assertIn(line, (output / 'report.html').read_text())

    def test_a_job_that_is_killed_has_no_result(self):
        project = write_project(self.folder / 'bad', {**THREE, 'd': 'killed'})
        done = self.run_city(project)
        self.assertEqual(done.returncode, 3, done.stdout)
        self.assertFalse((self.folder / 'bad/out/jobs/map/d.json').exists())
        (self.folder / 'bad/bags/d.bag').write_text('good now')
        self.assertEqual(self.run_city(project).returncode, 0)


class LeftOvers(MapCityTest):
    """What an earlier run has left where a job fails now."""
    def test_its_loops_are_not_joined(self):
        output = self.city('one', THREE)
        project = write_project(self.folder / 'one', {**THREE, 'c': 'good but longer'})
        done = self.run_city(project, TOY_FAILS='loops')
        self.assertEqual(done.returncode, 4, done.stdout)
        self.assertEqual([file.stem for file in (output / 'loops').glob('*.json')], ['a--b--000'])
        self.assertNotIn('"b": "c"', (output / 'city/graph').read_text())
        self.assertEqual(self.run_city(project, '--retry-failed').returncode, 0)
        self.assertIn('"b": "c"', (output / 'city/graph').read_text())

    def test_its_products_stay_and_are_called_so(self):
        output = self.city('one', THREE)
        for fails, old in (('build_map', ['products']), ('graph', ['city', 'products'])):
            project = write_project(self.folder / 'one', {**THREE, 'c': f'good without {fails}'})
            done = self.run_city(project, TOY_FAILS=fails)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertEqual((output / 'products/map.png').read_text().count('good 3'), 1)
            page = (output / 'report.html').read_text()
            for name in ('city', 'products'):
                for text in (done.stdout, page):
                    self.assertEqual(f'{name}: is still that of an earlier run' in text, name in old, text)
        done = self.run_city(project, '--retry-failed')
        self.assertNotIn('earlier run', done.stdout)
        self.assertNotIn('earlier run', (output / 'report.html').read_text())


class Kills(MapCityTest):
    def kill_somewhere(self, words, generator, environment):
        """Starts a run and kills one or all of its processes; False if it ended before."""
        process = subprocess.Popen(words, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   start_new_session=True)
        time.sleep(generator.uniform(0.1, 1.5))
        family = descendants(process.pid)
        victims = [process.pid] if generator.random() < 0.5 else [process.pid, *family]
        if family and generator.random() < 0.3:
            victims = [generator.choice(family)]
        for pid in victims:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        return process.wait() != 0

    def kill_and_go_on(self, engine, kills):
        many = {f'd{number:02d}': f'good {number}' for number in range(4)}
        expected = products_of(self.city('undisturbed', many))
        generator = random.Random(1)
        project = write_project(self.folder / 'killed', many)
        environment = {**self.environment, 'TOY_SECONDS': '0.15'}
        killed = 0
        for _ in range(kills):
            words = self.words(project, '--jobs', '2', *engine)
            killed += self.kill_somewhere(words, generator, environment)
        done = self.run_city(project, engine=engine[0] if engine else None)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(products_of(self.folder / 'killed/out'), expected)
        self.assertGreater(killed, 1)

    def test_any_moment_leads_to_the_same_bytes(self):
        self.kill_and_go_on(['--local'], int(os.environ.get('CITY_KILLS', '6')))

    @unittest.skipUnless(shutil.which('snakemake'), 'Snakemake is not installed')
    def test_any_moment_with_snakemake(self):
        self.kill_and_go_on([], int(os.environ.get('CITY_KILLS', '3')))


def descendants(pid):
    children = {}
    for path in pathlib.Path('/proc').glob('[0-9]*/stat'):
        try:
            fields = path.read_text().rpartition(')')[2].split()
        except OSError:
            continue
        children.setdefault(int(fields[1]), []).append(int(path.parent.name))
    found, queue = [], [pid]
    while queue:
        new = children.get(queue.pop(), [])
        found += new
        queue += new
    return found


@unittest.skipUnless(shutil.which('snakemake'), 'Snakemake is not installed')
class Snakemake(MapCityTest):
    def test_it_leads_to_the_same_bytes(self):
        bad = {**THREE, 'd': 'empty'}
        local, by_engine = (write_project(self.folder / name, bad) for name in ('local', 'engine'))
        self.assertEqual(self.run_city(local).returncode, 4)
        done = self.run_city(by_engine, '--jobs', '2', engine=None)
        self.assertEqual(done.returncode, 4, done.stdout)
        self.assertEqual(products_of(self.folder / 'local/out'), products_of(self.folder / 'engine/out'))

    def test_what_the_local_engine_has_done_is_done(self):
        self.city('one', THREE)
        self.commands()
        done = self.run_city(self.folder / 'one/project.yaml', engine=None)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(self.commands(), [])

    def changed(self, change, *, local=False):
        """Commands that a run has for a change of a city that is done; it is then done again."""
        project = write_project(self.folder / 'one', THREE)
        engine = '--local' if local else None
        self.assertEqual(self.run_city(project, engine=engine).returncode, 0)
        self.commands()
        change(project)
        done = self.run_city(project, engine=None)
        self.assertEqual(done.returncode, 0, done.stdout)
        commands = [line.split()[0] if line.split()[0] != 'join_drives' else line.split()[1] for line in self.commands()]
        self.assertNotIn('waiting', self.run_city(project, '--status').stdout)
        return commands

    def test_a_recording_that_is_gone_leaves_the_city(self):
        commands = self.changed(lambda project: (project.parent / 'bags/c.bag').unlink())
        self.assertEqual(commands, ['pairs', 'graph', 'build_map', 'map_quality'])
        self.assertNotIn('good 3', (self.folder / 'one/out/city/graph').read_text())

    def test_an_older_recording_is_another_one(self):
        def replace(project):
            bag = project.parent / 'bags/c.bag'
            bag.write_text('good but older')
            os.utime(bag, (1e9, 1e9))
        self.assertIn('map_bag', self.changed(replace))

    def test_the_content_of_configuration_counts(self):
        def configure(text):
            (self.folder / 'one').mkdir(exist_ok=True)
            (self.folder / 'one/back_end.yaml').write_text(text)
            return write_project(self.folder / 'one', THREE, 'config: back_end.yaml\n')
        self.assertEqual(self.run_city(configure('a: 1'), engine=None).returncode, 0)
        self.commands()
        project = configure('a: 2')
        self.assertEqual(self.run_city(project, engine=None).returncode, 0)
        self.assertEqual(sum(' loops ' in line for line in self.commands()), 2)

    def test_settings_of_a_city_of_the_local_engine_count(self):
        commands = self.changed(lambda project: write_project(project.parent, THREE, 'datum: [49, 8, 100]\n'), local=True)
        self.assertEqual(commands, ['graph', 'build_map', 'map_quality'])

    def test_it_goes_on_behind_a_job_of_a_run_that_was_killed(self):
        def map_again(project):
            (project.parent / 'bags/c.bag').write_text('good but longer')
            for job in ('check/c', 'map/c'):
                self.assertEqual(self.run_city(project, '--job', job).returncode, 0)
        self.assertIn('pairs', self.changed(map_again))

    def test_a_submitting_command(self):
        project = write_project(self.folder / 'one', THREE)
        done = self.run_city(project, '--cluster', 'sh -c \'"$0" >/dev/null 2>&1 & echo $!\'', '--jobs', '2', engine=None)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(products_of(self.folder / 'one/out'), products_of(self.city('local', THREE)))


if __name__ == '__main__':
    unittest.main()
