#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds what launch/*.launch make of their arguments, as roslaunch reads them.

check_launch.py: without a ROS master; the working folder is test/
"""
import os
import pathlib
import re
import shlex
import shutil
import sys
import tempfile
import unittest

import roslaunch.config
import roslaunch.xmlloader
import yaml

PACKAGE = pathlib.Path(__file__).resolve().parents[2]
FILES = ('mapping.launch', 'localization.launch')


class Launch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        cls.package = cls.folder / 'a workspace' / 'lidar_mapping'
        cls.package.mkdir(parents=True)
        shutil.copy(PACKAGE / 'package.xml', cls.package)
        for part in ('config', 'launch', 'rviz'):
            shutil.copytree(PACKAGE / part, cls.package / part)
        # This copy is the only package of the name.
        os.environ['CMAKE_PREFIX_PATH'] = ''
        os.environ['ROS_PACKAGE_PATH'] = str(cls.package.parent)
        os.environ['PWD'] = str(cls.folder)  # of the shell in which roslaunch is called

    def load(self, file, *arguments):
        config = roslaunch.config.ROSLaunchConfig()
        loader = roslaunch.xmlloader.XmlLoader(resolve_anon=False)
        loader.load(str(self.package / 'launch' / file), config, argv=[file, *arguments], verbose=False)
        return config

    def rviz_words(self, file, *arguments):
        (rviz,) = [node for node in self.load(file, *arguments).nodes if node.type == 'rviz']
        return shlex.split(rviz.args)

    def test_rviz_finds_its_file_in_a_folder_with_a_space(self):
        for file in FILES:
            words = self.rviz_words(file)
            self.assertTrue(pathlib.Path(words[words.index('-d') + 1]).is_file(), words)

    def test_rviz_follows_the_frames_of_the_arguments(self):
        for file in FILES:
            words = self.rviz_words(file, 'map_frame:=world', 'base_frame:=car')
            self.assertIn('-f', words)
            self.assertEqual(words[words.index('-f') + 1], 'world')
            shown = yaml.safe_load(pathlib.Path(words[words.index('-d') + 1]).read_text())
            target = shown['Visualization Manager']['Views']['Current']['Target Frame']
            transforms = [node.args.split()[-2:] for node in self.load(file, 'base_frame:=car').nodes
                          if node.type == 'static_transform_publisher']
            self.assertIn(['car', target], transforms)

    def test_rviz_listens_in_the_namespace_of_the_nodes(self):
        for file in FILES:
            (rviz,) = [node for node in self.load(file).nodes if node.type == 'rviz']
            words = shlex.split(rviz.args)
            text = pathlib.Path(words[words.index('-d') + 1]).read_text()
            topics = re.findall(r'\bTopic: (/\S+)', text)
            self.assertIn('/initialpose', topics)
            self.assertEqual(sorted(rviz.remap_args), sorted([topic, topic[1:]] for topic in topics))

    def overlays(self, file, *arguments):
        """What stands in the group of the overlays, and that nothing stands beside it."""
        beside = set(self.load(file).params)
        parameters = self.load(file, *arguments).params
        self.assertEqual([name for name in set(parameters) - beside if not name.startswith('/overlays/')], [])
        return {name[len('/overlays/'):]: parameter.value for name, parameter in parameters.items()
                if name.startswith('/overlays/')}

    def test_overlays_are_names_or_paths_from_the_folder_of_the_user(self):
        (self.folder / 'overlays').mkdir(exist_ok=True)
        for path in ('car_park.yaml', 'overlays/car_park.yaml'):
            (self.folder / path).write_text('preprocessing: {scan_period: 0.05}\n')
        for file in FILES:
            self.assertEqual(self.overlays(file), {})
            self.assertIn('sensor/preprocessing/distance_near_thresh', self.overlays(file, 'sensor:=vlp16'))
            self.assertIn('preset/front_end/voxel_size', self.overlays(file, 'preset:=indoor'))
            for kind in ('sensor', 'preset'):
                for path in ('car_park.yaml', 'overlays/car_park.yaml', self.folder / 'car_park.yaml'):
                    self.assertEqual(self.overlays(file, f'{kind}:={path}'),
                                     {f'{kind}/preprocessing/scan_period': 0.05})

    def test_overlays_of_an_earlier_launch_are_cleared(self):
        for file in FILES:
            self.assertIn('/overlays/', self.load(file).clear_params)

    def test_the_frame_of_the_lidar_is_that_of_the_clouds_unless_it_is_named(self):
        for file in FILES:
            frames = {name: parameter.value
                      for name, parameter in self.load(file, 'lidar_frame:=roof').params.items()
                      if name.endswith('lidar_frame')}
            self.assertEqual(frames.get('/front_end_node/lidar_frame'), 'roof')
            self.assertEqual([name for name in self.load(file).params if name.endswith('lidar_frame')], [])

    def back_end(self, *arguments):
        """The private parameters that are set beside the files."""
        parameters = self.load('mapping.launch', *arguments).params
        return {name: parameters[f'/back_end_node/{name}'].value if f'/back_end_node/{name}' in parameters else None
                for name in ('resume', 'session_directory')}

    def test_paths_begin_in_the_folder_of_the_user(self):
        given = self.back_end('resume:=town', 'session_directory:=drives/may')
        self.assertEqual(given, {'resume': str(self.folder / 'town'),
                                 'session_directory': str(self.folder / 'drives/may')})

    def test_paths_that_are_whole_or_words_stay(self):
        configured = self.back_end()
        for path in ('/data/town', '~/town'):
            self.assertEqual(self.back_end(f'resume:={path}', f'session_directory:={path}'),
                             {'resume': path, 'session_directory': path})
        self.assertEqual(self.back_end('resume:=latest')['resume'], 'latest')
        self.assertEqual(self.back_end('resume:=none', 'session_directory:=as_configured'), configured)
        self.assertEqual(self.back_end('resume:=', 'session_directory:='), configured)

    def test_the_front_end_is_told_that_a_session_is_read(self):
        waits = [bool(self.load('mapping.launch', *words).params.get('/run_state/resuming'))
                 for words in ([], ['resume:=none'], ['resume:=latest'])]
        self.assertEqual(waits, [False, False, True])


if __name__ == '__main__':
    unittest.main()
