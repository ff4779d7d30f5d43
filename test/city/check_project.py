#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds scripts/city/project.py: what a project file means, and what each mistake in it is called."""
import json
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'scripts'))
from city.project import ProjectError, read_project  # noqa: E402


class ProjectTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        for name in ('monday/a.bag', 'monday/b.bag', 'tuesday/a.bag', 'tuesday/c d.bag'):
            (self.folder / name).parent.mkdir(exist_ok=True)
            (self.folder / name).touch()

    def read(self, text):
        path = self.folder / 'project.yaml'
        path.write_text(text)
        return read_project(path)

    def error(self, text):
        with self.assertRaises(ProjectError) as caught:
            self.read(text)
        self.assertNotIn('\n', str(caught.exception))
        return str(caught.exception)


class Meaning(ProjectTest):
    def test_each_match_of_a_pattern_is_a_drive(self):
        project = self.read('recordings:\n  - path: monday/*.bag\n')
        self.assertEqual(list(project.drives), ['a', 'b'])
        self.assertEqual(project.drives['a'].paths, [self.folder / 'monday/a.bag'])
        self.assertEqual(project.output, self.folder / 'city')

    def test_a_list_is_one_drive_of_several_bags(self):
        project = self.read('recordings:\n  - path: [monday/a.bag, monday/b.bag]\n    name: whole\n')
        self.assertEqual(list(project.drives), ['whole'])
        self.assertEqual(len(project.drives['whole'].paths), 2)

    def test_equal_names_get_that_of_their_folder_but_the_first(self):
        project = self.read('recordings:\n  - path: "*/*.bag"\n')
        self.assertEqual(list(project.drives), ['a', 'b', 'tuesday_a', 'c_d'])

    def test_given_names_are_final(self):
        for recordings, names in (('{path: monday/a.bag, name: a}, {path: tuesday/a.bag}', ['a', 'tuesday_a']),
                                  ('{path: tuesday/a.bag}, {path: monday/a.bag, name: a}', ['tuesday_a', 'a']),
                                  ('{path: monday/a.bag, name: day}, {path: monday/a.bag}', ['day', 'a'])):
            self.assertEqual(list(self.read(f'recordings: [{recordings}]\n').drives), names)

    def test_a_recording_keeps_its_name(self):
        (self.folder / 'city/jobs/check').mkdir(parents=True)
        (self.folder / 'city/jobs/names.json').write_text(json.dumps(
            self.read('recordings: [{path: tuesday/*.bag}]\n').names()))
        project = self.read('recordings: [{path: "*/*.bag"}]\n')
        self.assertEqual(list(project.drives), ['monday_a', 'b', 'a', 'c_d'])
        self.assertEqual(project.drives['a'].paths, [self.folder / 'tuesday/a.bag'])
        project = self.read('recordings: [{path: monday/b.bag, name: a}, {path: tuesday/a.bag}]\n')
        self.assertEqual(list(project.drives), ['a', 'tuesday_a'])

    def test_a_recording_keeps_its_name_from_before_names_were_written_down(self):
        (self.folder / 'city/jobs/check').mkdir(parents=True)
        (self.folder / 'city/jobs/map').mkdir()
        for name in ('monday_a', 'tuesday_a', 'b'):
            (self.folder / f'city/jobs/map/{name}.json').touch()
        self.assertEqual(list(self.read('recordings:\n  - path: "*/*.bag"\n').drives),
                         ['monday_a', 'b', 'tuesday_a', 'c_d'])

    def test_names_that_cannot_be_read_are_none(self):
        (self.folder / 'city/jobs/check').mkdir(parents=True)
        (self.folder / 'city/jobs/names.json').write_text('[]')
        self.assertEqual(list(self.read('recordings: [{path: monday/a.bag}]\n').drives), ['a'])

    def test_settings_of_a_recording_win_over_the_defaults(self):
        project = self.read('defaults: {sensor: vlp16, start: 2, topics: {gnss: /fix}}\n'
                            'recordings:\n  - path: monday/a.bag\n  - {path: monday/b.bag, sensor: hdl64e, duration: 5}\n')
        self.assertEqual(project.drives['a'].map_arguments(),
                         ['--sensor', 'vlp16', '--start', '2', '--gnss', '/fix'])
        self.assertEqual(project.drives['b'].map_arguments(),
                         ['--sensor', 'hdl64e', '--start', '2', '--duration', '5', '--gnss', '/fix'])

    def test_a_calibration_becomes_parameters_that_win(self):
        (self.folder / 'cal.yaml').write_text('preprocessing:\n  lidar_position: [1.0, 0.0, 1.8]\n  scan_period: 0.1\n')
        project = self.read('recordings:\n  - {path: monday/a.bag, calibration: cal.yaml, parameters: ["map/a: 1"]}\n')
        self.assertEqual(project.drives['a'].map_arguments(),
                         ['--parameter', 'map/a: 1', '--parameter', 'preprocessing/lidar_position: [1.0, 0.0, 1.8]',
                          '--parameter', 'preprocessing/scan_period: 0.1'])

    def test_the_check_judges_by_the_settings_of_the_map(self):
        (self.folder / 'front_end.yaml').touch()
        (self.folder / 'cal.yaml').write_text('preprocessing: {imu_acceleration_unit: G}\n')
        project = self.read('recordings:\n  - {path: monday/a.bag, start: 5, duration: 3, config: front_end.yaml, sensor: vlp16, '
                            'preset: indoor, calibration: cal.yaml, parameters: ["map/a: 1"], topics: {imu: /imu}}\n')
        self.assertEqual(project.drives['a'].check_arguments(),
                         ['--config', str(self.folder / 'front_end.yaml'), '--sensor', 'vlp16', '--preset', 'indoor',
                          '--parameter', 'map/a: 1', '--parameter', 'preprocessing/imu_acceleration_unit: G', '--imu', '/imu'])

    def test_resources_keep_what_is_not_given(self):
        project = self.read('recordings: [{path: monday/a.bag}]\nresources: {map: {mem_mb: 9000}}\n')
        self.assertEqual(project.resources('map')['mem_mb'], 9000)
        self.assertEqual(project.resources('map')['threads'], 2)


class Mistakes(ProjectTest):
    def test_unknown_keys(self):
        self.assertIn("recordings[0].sensr: 'vlp16': there is no such key; write one of",
                      self.error('recordings:\n  - {path: monday/a.bag, sensr: vlp16}\n'))
        self.assertIn('colour: ', self.error('recordings: [{path: monday/a.bag}]\ncolour: red\n'))
        self.assertIn('resources.map.memory: 1: ',
                      self.error('recordings: [{path: monday/a.bag}]\nresources: {map: {memory: 1}}\n'))

    def test_wrong_types(self):
        one = 'recordings: [{path: monday/a.bag}]\n'
        for text, message in ((one + 'datum: 3\n', 'datum: 3: write [latitude'),
                              (one + 'datum: [95, 8, 1]\n', 'datum: [95, 8, 1]: write'),
                              (one + 'map: {formats: [dxf]}\n', "map.formats: ['dxf']: write a list of pcd"),
                              (one + 'map: {tile_size: -1}\n', 'map.tile_size: -1: write metres'),
                              (one + 'reports: 1\n', 'reports: 1: write true or false'),
                              (one + 'resources: {map: {threads: 0}}\n', 'resources.map.threads: 0: write'),
                              ('recordings: [{path: monday/a.bag, start: true}]\n', 'start: True: write seconds'),
                              ('recordings: 3\n', 'recordings: 3: write a list'),
                              ('3\n', 'the project file: 3: is no list'),
                              ('', 'the project file: nothing: is no list')):
            with self.subTest(text):
                self.assertIn(message, self.error(text))

    def test_missing_files(self):
        self.assertIn("recordings[0].path: 'friday/*.bag': nothing there matches", self.error('recordings: [{path: friday/*.bag}]\n'))
        self.assertIn('there is no', self.error('recordings: [{path: [monday/a.bag, x.bag]}]\n'))
        self.assertIn("recordings[0].config: 'none': there is no",
                      self.error('recordings: [{path: monday/a.bag, config: none}]\n'))
        self.assertIn("sensor: 'none.yaml': there is no", self.error('recordings: [{path: monday/a.bag, sensor: none.yaml}]\n'))
        with self.assertRaisesRegex(ProjectError, "project: '/none.yaml': cannot be read"):
            read_project('/none.yaml')

    def test_text_that_is_no_yaml(self):
        self.assertIn('is no YAML in line 3', self.error('recordings:\n  - path: [\n'))

    def test_an_output_with_files_of_others(self):
        one = 'recordings: [{path: monday/a.bag}]\n'
        self.assertIn(f"output: '.': {self.folder} holds other files; name a folder that is new",
                      self.error(one + 'output: .\n'))
        self.assertIn('is no folder', self.error(one + 'output: monday/b.bag\n'))
        (self.folder / 'city').mkdir()
        self.assertEqual(self.read(one).output, self.folder / 'city', 'an empty one is good')
        (self.folder / 'city/jobs').mkdir()
        self.assertIn('holds other files', self.error(one))
        (self.folder / 'city/jobs/check').mkdir(parents=True)
        self.assertEqual(self.read(one).output, self.folder / 'city', 'map_city has been there')

    def test_a_recording_in_the_city_itself(self):
        (self.folder / 'city/jobs/check').mkdir(parents=True)
        (self.folder / 'monday').rename(self.folder / 'city/drives')
        self.assertIn('lies in the city itself', self.error('recordings: [{path: city/drives/a.bag}]\n'))
        self.assertIn('lies in the city itself', self.error('recordings: [{path: city/drives}]\n'))
        (self.folder / 'link').symlink_to(self.folder / 'city/drives')
        self.assertIn('lies in the city itself', self.error('recordings: [{path: link/a.bag}]\n'))

    def test_a_recording_that_contains_the_city(self):
        for path, output in (('.', 'city'), ('monday', 'monday'), ('monday', 'monday/city')):
            text = f'recordings: [{{path: {path}}}]\noutput: {output}\n'
            if output == 'monday':
                (self.folder / 'monday/jobs/check').mkdir(parents=True)
            self.assertIn('contains the city itself', self.error(text))

    def test_one_recording_twice(self):
        self.assertIn('is there twice; give one of them another "name"',
                      self.error('recordings: [{path: monday/a.bag}, {path: monday/*.bag}]\n'))

    def test_one_name_twice(self):
        self.assertIn(f"b.bag': is called day, like '{self.folder}/monday/a.bag'; give one of them another",
                      self.error('recordings: [{path: monday/a.bag, name: day}, {path: monday/b.bag, name: day}]\n'))
        self.assertIn('others are called a and monday_a already; give one of them',
                      self.error('recordings: [{path: monday/a.bag}, {path: monday/b.bag, name: a}, '
                                 '{path: tuesday/a.bag, name: monday_a}]\n'))


if __name__ == '__main__':
    unittest.main()
