#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Run the commands of README.md, CONTRIBUTING.md and doc/ as they are written, and check the names in the pages.

Each command of a bash block is run in a folder that holds a short simulated drive under the names that
the pages use (drive.bag, SESSION, monday, ...), with a home and a ROS master of its own. It fails when
its status is not 0 or a line of its output is red. What cannot be run is named below, with the reason;
a command that is neither run nor named does not exist. Tests, files, options and links that the pages
name have to exist. scripts/check_documentation prepares the environment.

usage: check_documentation.py [--keep FOLDER] [PAGE ...]
"""
import argparse
import contextlib
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from pages import Page, Text

ROOT = pathlib.Path(__file__).resolve().parent.parent
PACKAGE = 'lidar_mapping'
FAULTY_PAGE = ROOT / 'test' / 'documentation' / 'faulty.md'
PATIENCE = 120  # s, for one command

# Commands that are not run: pattern, reason.
NOT_RUN = (
    (r'^(scripts/(demo|test|build)|\.ci/run)\b', 'installs and builds; check_bare_debian runs what a user begins with'),
    (r'^cmake |^scripts/(fuzz|check_sanitizers|check_clang|check_tidy|measure_coverage)\b',
     'a second build takes too long'),
    (r'^source scripts/setup\.bash', 'done before every command'),
    (r'catkin_ws|^source devel/setup', 'scripts/check_workspace runs it'),
    (r'^docker ', 'scripts/check_container runs it'),
    (r'benchmark_(preprocessing|pose_graph)|gnss_faults|street_graph', 'is not built by default'),
    (r'optimize_graph g\.lmg', 'needs a graph of street_graph, which is not built by default'),
    (r'^editor ', 'waits for a person'),
    (r'^rosservice call /save_session', 'needs a drive beyond the map; rostest_localization_node has one'),
    (r'2011_09_26_drive', 'needs a recording of KITTI'),
    (r'^evo_', 'evo is not among the packages; a test of test_session runs it where it is installed'),
    (r'^rosbag play -r 0\.5$', 'is a part of a command'),
)
# What a reader fills in, where no file of that name can stand for it.
FILLED_IN = ((r'\bSTAGE\b', 'front_end'),)
# Long drives are cut and bags played faster: pattern, replacement.
SHORTENED = (
    (r'simulate_drive (?!.*--(duration|start))', r'simulate_drive --duration 2 '),
    (r'--start 60', r'--start 60 --duration 63'),
    (r'--duration 100', r'--duration 3'),
    (r'odometry_campaign .*', r'odometry_campaign --lidars vlp16 --duration 3 --case clean'),
    (r'odometry_benchmark drive\.bag --method (V?GICP)', r'odometry_benchmark a_0.bag --method \1'),
    (r'rosbag play (?!.*-r )', r'rosbag play -r 3 '),
    (r'http\.server 8000', r'http.server --bind 127.0.0.1 0'),  # on a free port
)
# Commands that run until they are ended; the rest of their block runs meanwhile.
LASTING = re.compile(r'^(roslaunch|roscore|python3 -m http\.server|rosrun (tf2_ros|rviz|lidar_mapping \w+_node(?! --))) ?')
RED = re.compile(r'\[(ERROR|FATAL)\]|\bERROR\b|\x1b\[31m|Traceback|\bFailed\b|has died|^success: False')
# Folders whose files the pages name by their path.
FOLDERS = ('src', 'test', 'scripts', 'config', 'launch', 'doc', 'include', 'msg', 'srv', 'rviz', 'cmake', '.ci')
TOPICS = {'/kitti/velo/pointcloud': '/velodyne_points', '/kitti/oxts/imu': '/imu/data',
          '/kitti/oxts/gps/fix': '/fix'}


def free_port():
    with contextlib.closing(socket.socket()) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


def wait_for_port(port):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        with contextlib.suppress(OSError), socket.create_connection(('127.0.0.1', port), timeout=1):
            return
        time.sleep(0.1)


def tail(text, lines=12):
    return '\n'.join('    ' + line for line in text.rstrip().splitlines()[-lines:])


# rviz 1.14 itself may end by a signal when it is asked to end, and rarely while it shows something, most often on a busy
# machine: with the software renderer, pixels of its background lie where its heap should be (most of the addresses end in
# their colour, ff141428), and either the processor (11) or the allocator (6) ends it. A block in which it does the latter is run again, up to so many times.
RVIZ_CRASHES_BORNE = 2
RVIZ_CRASHES = re.compile(r'^.*\[rviz-\d+\] process has died \[pid \d+, exit code -(?:6|11)\b.*$', re.MULTILINE)


def red_line(output):
    return next((line for line in output.splitlines() if RED.search(line)), None)


class Problems:
    def __init__(self):
        self.all = []

    def add(self, where, what, output=''):
        self.all.append(f'{where}: {what}')
        print(f'{where}\n  {what}' + (f'\n{tail(output)}' if output else ''), flush=True)


class Data:
    """The recordings and sessions that commands are run on."""

    def __init__(self, folder, environment):
        self.folder = folder
        self.environment = environment
        folder.mkdir()
        self._simulate()
        self._map()

    def _run(self, *words):
        result = subprocess.run([str(word) for word in words], cwd=self.folder, env=self.environment,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if result.returncode != 0:
            sys.exit('check_documentation: cannot make its data: ' + ' '.join(map(str, words)) + '\n'
                     + tail(result.stdout, 40))

    def _simulate(self):
        simulate = ('rosrun', PACKAGE, 'simulate_drive', '--lidar', 'vlp16')
        self._run(*simulate, 'monday.bag', '--duration', '30', '--truth', 'truth.tum')
        self._run(*simulate, 'tuesday.bag', '--duration', '30', '--pass', '1')
        self._run(*simulate, 'a_0.bag', '--duration', '10')
        self._run(*simulate, 'a_1.bag', '--start', '10', '--duration', '20')
        self._run('/usr/bin/python3', ROOT / 'scripts' / 'rename_topics.py', 'monday.bag', 'drive.bag',
                  *(f'{old}:={new}' for old, new in TOPICS.items()))

    def _map(self):
        for day in ('monday', 'tuesday'):
            self._run('rosrun', PACKAGE, 'map_bag', f'{day}.bag', '-o', day, '--formats', 'pcd')

    def lay_out(self, folder):
        """A folder in which the words of the pages are files and folders."""
        folder.mkdir(parents=True)
        for name, source in (('drive.bag', 'drive.bag'), ('BAG', 'drive.bag'), ('a_0.bag', 'a_0.bag'),
                             ('a_1.bag', 'a_1.bag'), ('truth.tum', 'truth.tum'), ('T.tum', 'truth.tum')):
            (folder / name).symlink_to(self.folder / source)
        (folder / 'recordings').mkdir()
        for name in ('a_0.bag', 'a_1.bag'):
            (folder / 'recordings' / name).symlink_to(self.folder / name)
        for name, source in (('monday', 'monday'), ('tuesday', 'tuesday'), ('MONDAY', 'monday'),
                             ('TUESDAY', 'tuesday'), ('SESSION', 'monday')):
            shutil.copytree(self.folder / source, folder / name)
        shutil.copytree(ROOT / 'config', folder / 'config')
        for name in ('monday.bag', 'tuesday.bag'):
            (folder / name).symlink_to(self.folder / name)
        (folder / 'town.yaml').write_text('recordings: [{path: "*day.bag"}]\noutput: town_city\n')


class Block:
    """Runs the commands of one block, one after the other, in one shell."""

    def __init__(self, folder, environment, problems, rviz_may_crash=False):
        self.folder = folder
        self.environment = environment
        self.problems = problems
        self.rviz_may_crash = rviz_may_crash
        self.rviz_crashed = False
        self.lasting = []
        self._start_shell()

    def _start_shell(self):
        """What a command does to the shell (cd, export) holds for the next one."""
        read, self.status_pipe = os.pipe()
        self.shell = subprocess.Popen(['/bin/bash'], stdin=subprocess.PIPE, pass_fds=[self.status_pipe],
                                      cwd=self.folder, env=self.environment, start_new_session=True, text=True)
        os.close(self.status_pipe)
        self.statuses = os.fdopen(read)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for command, process, log in reversed(self.lasting):
            self._end(command, process, log)
        self.shell.stdin.close()
        self.shell.wait()

    def run(self, command):
        text = command.text.strip()
        for pattern, replacement in SHORTENED + FILLED_IN:
            text = re.sub(pattern, replacement, text)
        if text.startswith('roslaunch') and 'DISPLAY' not in self.environment:
            text = re.sub(r'^(roslaunch \S+ \S+)', r'\1 rviz:=false', text)
        if LASTING.match(text):
            self._start(command, text)
        else:
            self._run_to_end(command, text)

    def _run_to_end(self, command, text):
        log = self.folder / '.output'
        self.shell.stdin.write(f'{{ {text}\n}} >{log} 2>&1 </dev/null; echo $? >&{self.status_pipe}\n')
        self.shell.stdin.flush()
        watch = signal.signal(signal.SIGALRM, self._give_up)
        signal.alarm(PATIENCE)
        status = self.statuses.readline().strip()
        signal.alarm(0)
        signal.signal(signal.SIGALRM, watch)
        output = log.read_text(errors='replace')
        if not status:
            self.shell.wait()
            self._start_shell()
        if status != '0':
            self.problems.add(command, f'ends with status {status or "none: it took too long, or ended the shell"}', output)
        elif red_line(output):
            self.problems.add(command, f'says {red_line(output).strip()!r}', output)

    def _give_up(self, *_):
        os.killpg(self.shell.pid, signal.SIGKILL)

    def _start(self, command, text):
        log = self.folder / f'.output_{command.line}'
        with open(log, 'w') as file:
            # Python says at once, not in the end, that its server is up.
            environment = {**self.environment, 'PYTHONUNBUFFERED': '1'}
            process = subprocess.Popen(['/bin/bash', '-c', f'exec {text}'], cwd=self.folder, env=environment,
                                       stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                       start_new_session=True)
        self.lasting.append((command, process, log))
        if not self._is_up(text, process, log):
            self.problems.add(command, 'does not start', log.read_text(errors='replace'))

    def _is_up(self, text, process, log):
        """Whether the service of the command is available in the end, or rviz has crashed where it may."""
        if text.startswith('roslaunch'):
            asked = ['rosservice', 'list']
            localizes = 'localization.launch' in text
            wanted = {'/relocalize', '/load_map', '/save_session'} if localizes else {'/optimize_map', '/save_map'}
            if 'DISPLAY' in self.environment and 'rviz:=false' not in text:
                # rviz 1.14 may end by a signal if it is interrupted before it has begun; then it offers this.
                wanted.add('/rviz/reload_shaders')
        elif 'static_transform_publisher' in text:
            asked, wanted = ['rostopic', 'list'], {'/tf_static'}
        elif 'http.server' in text:
            asked, wanted = ['grep', '--only-matching', 'Serving', str(log)], {'Serving'}
        else:
            return True
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and process.poll() is None:
            answer = subprocess.run(asked, env=self.environment, capture_output=True, text=True).stdout
            if wanted <= set(answer.split()):
                return True
            if self.rviz_may_crash and RVIZ_CRASHES.search(log.read_text(errors='replace')):
                return True
            time.sleep(0.3)
        return False

    def _end(self, command, process, log):
        has_ended = process.poll() is not None
        said = log.read_text(errors='replace')
        if not has_ended:
            os.killpg(process.pid, signal.SIGINT)
            try:
                process.wait(timeout=60)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                self.problems.add(command, 'does not end when it is asked to')
        output = log.read_text(errors='replace')
        if has_ended:
            self.problems.add(command, f'ended by itself with status {process.returncode}', output)
        said_at_end = RVIZ_CRASHES.sub('', output[len(said):])
        if self.rviz_may_crash and RVIZ_CRASHES.search(said):
            self.rviz_crashed = True
            said = RVIZ_CRASHES.sub('', said)
        red = red_line(said) or red_line(said_at_end)
        if red:
            self.problems.add(command, f'says {red.strip()!r}', output)


@contextlib.contextmanager
def snapshot(*folders):
    """A function that puts the folders back to what they are now: commands refuse to overwrite what they made before."""
    with tempfile.TemporaryDirectory(prefix='lidar_mapping_before_') as copies:
        pairs = [(folder, pathlib.Path(copies) / str(number)) for number, folder in enumerate(folders)]
        for folder, copy in pairs:
            shutil.copytree(folder, copy, symlinks=True)

        def restore():
            for folder, copy in pairs:
                shutil.rmtree(folder)
                shutil.copytree(copy, folder, symlinks=True)
        yield restore


class Commands:
    """All commands of the pages."""

    def __init__(self, environment, problems):
        self.environment = environment
        self.problems = problems
        self.count = 0
        self.not_run = {}

    def run(self, page, folder):
        blocks = page.blocks + [[span] for span in page.spans() if self._is_command(span.text)]
        for block in blocks:
            commands = [command for command in block if self._is_run(command)]
            if not commands:
                continue
            self.count += len(commands)
            if not any('roslaunch' in command.text for command in commands):
                self._run_block(commands, folder, rviz_may_crash=False)
                continue
            with snapshot(folder, pathlib.Path(self.environment['HOME'])) as restore:
                crashes = 0
                while self._run_block(commands, folder, rviz_may_crash=crashes < RVIZ_CRASHES_BORNE):
                    crashes += 1
                    print(f'{commands[0]}\n  rviz ended by a signal: the block is run again', flush=True)
                    restore()

    def _run_block(self, commands, folder, rviz_may_crash):
        """Whether rviz crashed, where it may."""
        with self._master(commands), Block(folder, self.environment, self.problems, rviz_may_crash) as shell:
            for command in commands:
                began = time.monotonic()
                shell.run(command)
                print(f'{time.monotonic() - began:6.1f} s  {command}', flush=True)
        return shell.rviz_crashed

    @staticmethod
    def _is_command(span):
        """Inline code that a reader need not fill in."""
        return re.match(r'^(rosrun|rosservice|rosbag) \S+ ', span) and not re.search(r'\.\.\.|[\[<|]', span)

    def _is_run(self, command):
        for pattern, reason in NOT_RUN:
            if re.search(pattern, command.text.strip()):
                self.not_run.setdefault(pattern, (reason, []))[1].append(command)
                return False
        return True

    @contextlib.contextmanager
    def _master(self, commands):
        """One that lasts as long as a block which needs one and does not start it."""
        words = ' '.join(command.text for command in commands)
        needs = re.search(r'static_transform|rosservice|rosbag play|rostopic|_node', words)
        self.environment['ROS_MASTER_URI'] = f'http://localhost:{free_port()}'
        if not needs or 'roslaunch' in words:
            yield
            return
        port = int(self.environment['ROS_MASTER_URI'].rsplit(':', 1)[1])
        process = subprocess.Popen(['rosmaster', '--core', '-p', str(port)], env=self.environment,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            wait_for_port(port)
            yield
        finally:
            process.send_signal(signal.SIGINT)
            process.wait()


class Names:
    """What the pages name: links, files, tests, options, arguments of launch files."""

    def __init__(self, environment, problems):
        self.environment = environment
        self.problems = problems
        # One that the repository ignores or a build makes does not count.
        listed = subprocess.run(['find', '.', '-name', '.git', '-prune', '-o', '-name', '.build*', '-prune', '-o',
                                 '-type', 'f', '-print'], cwd=ROOT, capture_output=True, text=True, check=True)
        self.files = [name[2:] for name in listed.stdout.splitlines()]
        self.base_names = {name.rsplit('/', 1)[-1] for name in self.files}
        self.tests = self._tests()
        self.programs = set(re.findall(r'lidar_mapping_executable\((\w+)', self._text('src/tools/CMakeLists.txt')))
        self.help = {}

    @staticmethod
    def _text(name):
        return (ROOT / name).read_text()

    def _tests(self):
        """Suite.Name of every test."""
        pattern = re.compile(r'^\s*(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)', re.MULTILINE)
        return {f'{suite}.{name}' for file in self.files if re.match(r'test/.*\.cpp$', file)
                for suite, name in pattern.findall(self._text(file))}

    def check(self, page):
        for line in page.misplaced:
            self.problems.add(line, 'is a command outside of a bash block: nobody runs it')
        for link in page.links():
            self._check_link(page, link)
        for span in page.spans():
            self._check_test(span)
            self._check_file(span)
            self._check_options(span)
            self._check_arguments(span)
        for block in page.blocks:
            for command in block:
                for name in re.findall(r'gtest_filter=[\'"]?(\w+\.[\w*]+)', command.text):
                    self._check_test(Text(command.page, command.line, name))

    def _check_link(self, page, link):
        if re.match(r'\w+:', link.text):
            return
        name, _, anchor = link.text.partition('#')
        base = (ROOT / page.name).parent
        target = (base / name).resolve() if name else ROOT / page.name
        if not target.exists():
            return self.problems.add(link, 'leads nowhere')
        if anchor and anchor not in Page(target, name).anchors():
            self.problems.add(link, 'leads to no heading')

    def _check_test(self, span):
        for name in re.findall(r'(?<![\w/:.])([A-Z]\w+\.(?:[A-Z]\w+|\*))(?![\w(.])', span.text):
            suite = name[:-1]
            if name.endswith('*') and any(test.startswith(suite) for test in self.tests):
                continue
            if name not in self.tests and not self._is_file(name):
                self.problems.add(span, f'no test is called {name}')

    def _is_file(self, name):
        return name.rsplit('/', 1)[-1] in self.base_names

    def _check_file(self, span):
        name = span.text.split()[0].rstrip('/')
        name = re.sub(r'(\.\w+):[\w:~]+$', r'\1', name)  # file:function, which check_names.py looks up
        if name.split('/')[0] in FOLDERS and '/' in name:
            pattern = re.sub(r'<\w+>|\*', '*', name)
            if not list(ROOT.glob(pattern)):
                self.problems.add(span, f'{name} does not exist')
        elif re.fullmatch(r'[\w/]*\w\.(hpp|cpp|msg|srv|launch|rviz)', name) and not self._is_file(name):
            self.problems.add(span, f'no file is called {name}')
        elif re.fullmatch(r'(rostest|test)_\w+', name) and not self._is_file(name + '.cpp') \
                and not any(re.search(rf'\({name}\s', self._text(file)) for file in self.files
                            if re.match(r'test/.*CMakeLists.txt', file)):
            self.problems.add(span, f'no test program is called {name}')

    def _check_options(self, span):
        words = span.text.removeprefix(f'rosrun {PACKAGE} ').split()
        if not words or words[0] not in self.programs:
            return
        program, subcommand = words[0], words[1] if len(words) > 1 and re.fullmatch(r'[a-z]+', words[1]) else ''
        for option in re.findall(r'(?<![\w-])--[a-z][\w-]*', span.text):
            if option not in self._help(program, subcommand):
                self.problems.add(span, f'{program} has no option {option}')

    def _help(self, program, subcommand):
        for words in ((program,), (program, subcommand)):
            if words[-1] and words not in self.help:
                answer = subprocess.run(['rosrun', PACKAGE, *words, '--help'], env=self.environment,
                                        capture_output=True, text=True)
                self.help[words] = set(re.findall(r'--[a-z][\w-]*', answer.stdout))
        return self.help[(program,)] | self.help.get((program, subcommand), set())

    def _check_arguments(self, span):
        launch = re.search(r'(\w+\.launch)\b', span.text)
        if not launch or not (ROOT / 'launch' / launch.group(1)).exists():
            return
        known = set(re.findall(r'<arg name="(\w+)"', self._text(f'launch/{launch.group(1)}')))
        for name in re.findall(r'(\w+):=', span.text):
            if name not in known:
                self.problems.add(span, f'{launch.group(1)} has no argument {name}')


def clean_environment(home):
    """The environment of a terminal after `source scripts/setup.bash` only."""
    kept = {name: os.environ[name] for name in
            ('PATH', 'DISPLAY', 'XAUTHORITY', 'XDG_RUNTIME_DIR', 'LIBGL_ALWAYS_SOFTWARE', 'QT_X11_NO_MITSHM',
             'LIDAR_MAPPING_BUILD')
            if name in os.environ}
    home.mkdir(parents=True)
    return {**kept, 'HOME': str(home), 'LANG': 'C.UTF-8', 'TERM': 'dumb', 'USER': 'reader',
            **{name: value for name, value in os.environ.items()
               if name.startswith(('ROS_', 'CMAKE_PREFIX', 'PYTHON', 'LD_LIBRARY', 'PKG_CONFIG'))
               and name not in ('ROS_HOME', 'ROS_LOG_DIR', 'ROS_MASTER_URI')}}


def check_the_check(environment, folder):
    """Check a page of faults, each with the expected finding; stops if one is not found."""
    page = Page(FAULTY_PAGE, str(FAULTY_PAGE.relative_to(ROOT)))
    with open(os.devnull, 'w') as nothing, contextlib.redirect_stdout(nothing):
        problems = Problems()
        folder.mkdir(parents=True)
        Commands(environment, problems).run(page, folder)
        Names(environment, problems).check(page)
    found = '\n'.join(problems.all)
    wanted = re.findall(r'<!-- finds: (.*?) -->', '\n'.join(page.lines))
    missed = [text for text in wanted if text not in found]
    if missed or len(wanted) != len(problems.all):
        sys.exit(f'check_documentation: overlooks {missed} of {page.name}; found:\n{found}')


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--keep', type=pathlib.Path, help='a new folder to work in, which stays')
    parser.add_argument('pages', nargs='*', help='default: README.md, CONTRIBUTING.md, examples/README.md and all of doc/')
    return parser.parse_args()


def check(names, work):
    environment = clean_environment(work / 'home')
    problems = Problems()
    check_the_check(environment, work / 'faulty')
    pages = [Page(ROOT / name, name) for name in names]
    known = Names(environment, problems)
    for page in pages:
        known.check(page)
    data = Data(work / 'data', environment)
    commands = Commands(environment, problems)
    for page in pages:
        folder = work / page.name.replace('/', '_')
        data.lay_out(folder)
        commands.run(page, folder)
    for pattern, (reason, texts) in commands.not_run.items():
        print(f'not run ({reason}): ' + '; '.join(str(text).split('#')[0].strip() for text in texts))
    print(f'{commands.count} commands, {len(problems.all)} problems')
    return 1 if problems.all or commands.count == 0 else 0


def main():
    # Who is started in the background has SIGINT ignored, and all that it starts too: masters would not end.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    options = arguments()
    names = options.pages or ['README.md', 'CONTRIBUTING.md', 'examples/README.md'] + sorted(
        str(path.relative_to(ROOT)) for path in (ROOT / 'doc').rglob('*.md'))
    if options.keep:
        options.keep.mkdir(parents=True)
        return check(names, options.keep.resolve())
    with tempfile.TemporaryDirectory(prefix='lidar_mapping_pages_') as folder:
        return check(names, pathlib.Path(folder))


if __name__ == '__main__':
    sys.exit(main())
