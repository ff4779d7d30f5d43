# SPDX-License-Identifier: BSD-3-Clause
"""The report of a city: what became of each drive and why, a map of the drives, time by stage.

report.json holds what follows from the recordings alone, so it is the same bytes for the same city;
report.html also has times and the last lines of jobs that failed.
"""
import html
import math
import os

from city.jobs import WHOLE, read_json, write_json
from city.progress import duration_text
from city.project import STAGES

COLOURS = ('#1463a5', '#d97706', '#2f855a', '#b91c1c', '#6b46c1', '#0e7490', '#a16207', '#be185d', '#4d7c0f', '#475569')
MAX_POINTS = 400  # of a drive in the picture: finer than a pixel
WIDTH = 900  # of the picture, pixels
STYLE = '''body{font:15px/1.5 sans-serif;color:#1f2933;max-width:960px;margin:2em auto;padding:0 1em}
table{border-collapse:collapse;width:100%}td,th{text-align:left;padding:.3em .6em;border-bottom:1px solid #e4e7eb;
vertical-align:top}.bad{color:#b91c1c;font-weight:600}.good{color:#2f855a}.grey{color:#7b8794}
pre{background:#f5f7fa;padding:.6em;overflow-x:auto;font-size:13px}svg{width:100%;height:auto;background:#fafbfc}'''


def drive_figures(city, name, joined):
    """What became of a drive, in words and figures."""
    check, mapped = city.state('check', name) or {}, city.state('map', name) or {}
    drive = {'name': name, 'recording': [path.name for path in city.project.drives[name].paths],
             'result': 'waiting', 'reasons': [], 'faults': check.get('faults', [])}
    if mapped.get('result') in ('refused', 'failed'):
        drive['result'] = mapped['result']
        drive['reasons'].append(mapped['reason'])
    elif mapped.get('result') == 'done':
        drive['result'] = 'mapped'
        if mapped.get('is_doubtful'):
            drive['reasons'].append('parts of its own map cannot be trusted; look at its report')
    in_city = joined.get(name)
    if in_city and drive['result'] == 'mapped':
        drive['result'] = in_city['state']
        drive['reasons'] += in_city['notices']
        drive.update({key: in_city[key] for key in ('key_frames', 'key_frames_left_out', 'loops_used', 'loops_refused',
                                                    'has_gnss', 'uses_gnss')})
    return drive


def figures(city):
    content = read_json(city.joined / 'city.json') if city.result('join', WHOLE) == 'done' else None
    joined = {drive['name']: drive for drive in content['drives']} if content else {}
    failed = [(stage, name) for stage, name in city.jobs()
              if stage not in ('check', 'map', 'report') and city.result(stage, name) == 'failed']
    return {
        'drives': [drive_figures(city, name, joined) for name in city.project.drives],
        'datum': content['datum'] if content else None,
        'loops_between_drives': content['loops_between_drives'] if content else 0,
        'chunks': len(city.chunks()),
        'failed_jobs': [{'job': f'{stage}/{name}', 'reason': city.state(stage, name)['reason']} for stage, name in failed],
        'products': products(city),
    }


def products(city):
    if city.result('products', WHOLE) != 'done':
        return []
    return sorted(str(path.relative_to(city.output)) for path in city.products.iterdir())


def of_earlier_run(city):
    """A line for each folder that stayed as it was, since the job that would replace it has no good result."""
    return [f'{folder.name}: is still that of an earlier run' for stage, folder in
            (('join', city.joined), ('products', city.products)) if folder.exists() and city.result(stage, WHOLE) != 'done']


def problems(city):
    """A line for each drive that is not wholly in the city or in doubt, each job that failed, and what is old."""
    found = figures(city)
    lines = [f'{drive["name"]}: {drive["result"]}' + (f': {"; ".join(drive["reasons"])}' if drive['reasons'] else '')
             for drive in found['drives'] if drive['result'] != 'joined' or drive['reasons']]
    return lines + [f'{job["job"]}: failed: {job["reason"]}' for job in found['failed_jobs']] + of_earlier_run(city)


def read_positions(path):
    try:
        rows = [line.split() for line in path.read_text().splitlines()]
    except OSError:
        return []
    step = max(1, math.ceil(len(rows) / MAX_POINTS))
    return [(float(row[1]), float(row[2])) for row in rows[::step] + rows[-1:]]


def colour_of(number):
    return COLOURS[number % len(COLOURS)]


def picture(city):
    """The drives of the city from above, as SVG; nothing without a city."""
    ways = {name: read_positions(city.joined / 'drives' / f'{name}.tum') for name in city.project.drives}
    points = [point for way in ways.values() for point in way]
    if not points:
        return ''
    left, bottom = (min(point[axis] for point in points) for axis in (0, 1))
    right, top = (max(point[axis] for point in points) for axis in (0, 1))
    scale = (WIDTH - 40) / max(right - left, 1.0)
    height = max(scale * (top - bottom), 1.0) + 40
    if height > WIDTH:
        scale *= WIDTH / height
        height = scale * (top - bottom) + 40
    lines = []
    for number, (name, way) in enumerate(ways.items()):
        if way:
            at = ' '.join(f'{20 + scale * (x - left):.1f},{height - 20 - scale * (y - bottom):.1f}' for x, y in way)
            lines.append(f'<polyline points="{at}" fill="none" stroke="{colour_of(number)}" stroke-width="2" '
                         f'stroke-opacity="0.75"><title>{html.escape(name)}</title></polyline>')
    bar = 10 ** math.floor(math.log10(max(right - left, 10.0) / 2))
    lines.append(f'<path d="M20 {height - 6:.0f}h{scale * bar:.1f}" stroke="#1f2933" stroke-width="2"/>'
                 f'<text x="{26 + scale * bar:.0f}" y="{height - 2:.0f}" font-size="12">{bar:g} m</text>')
    return f'<svg viewBox="0 0 {WIDTH} {height:.0f}" role="img">{"".join(lines)}</svg>'


def link(city, path, text):
    target = city.output / path
    return f'<a href="{html.escape(str(path))}">{html.escape(text)}</a>' if target.exists() else html.escape(text)


def drive_row(city, number, drive):
    name = drive['name']
    good = drive['result'] == 'joined' and not drive['reasons']
    loops = f'{drive["loops_used"]} used, {drive["loops_refused"]} refused' if 'loops_used' in drive else ''
    notes = ''.join(f'<br>{html.escape(reason)}' for reason in drive['reasons'])
    if drive['faults']:
        lines = '<br>'.join(html.escape(line) for line in ('input check:', *drive['faults']))
        notes += f'<br><span class="grey">{lines}</span>'
    return (f'<tr><td><span style="color:{colour_of(number)}">&#9632;</span> '
            f'{link(city, f"drives/{name}/report.html", name)}</td>'
            f'<td><span class="{"good" if good else "bad"}">{html.escape(drive["result"])}</span>{notes}</td>'
            f'<td>{drive.get("key_frames", "")}</td><td>{loops}</td></tr>')


def stage_row(city, stage):
    times = [read_json(city.times_file(stage, name)) for name in city.names(stage)]
    times = [time for time in times if time]
    if not times:
        return ''
    return (f'<tr><td>{stage}</td><td>{len(times)}</td><td>{duration_text(sum(t["seconds"] for t in times))}</td>'
            f'<td>{duration_text(sum(t["processor_seconds"] for t in times))}</td>'
            f'<td>{max(t["memory_mb"] for t in times)} MB</td>'
            f'<td>{html.escape(", ".join(sorted({t["host"] for t in times})))}</td></tr>')


def failures(city):
    """The last lines of each job that failed."""
    parts = []
    for stage, name in city.jobs():
        state = city.state(stage, name)
        # The job of a refused drive has said nothing itself: its input check did.
        if stage == 'report' or not state or not state.get('last_lines') or state['result'] not in ('failed', 'refused'):
            continue
        lines = '\n'.join(state['last_lines'])
        parts.append(f'<h3>{html.escape(f"{stage}/{name}")}: {state["result"]}</h3><pre>{html.escape(lines)}</pre>')
    return ''.join(parts) or '<p>None.</p>'


def page(city, found):
    good = sum(drive['result'] == 'joined' for drive in found['drives'])
    drives = ''.join(drive_row(city, number, drive) for number, drive in enumerate(found['drives']))
    stages = ''.join(stage_row(city, stage) for stage in STAGES if stage != 'report')
    files = ''.join(f'<li>{link(city, path, path)}</li>' for path in found['products']) or '<li>none yet</li>'
    failed = ''.join(f'<p class="bad">{html.escape(job["job"])}: {html.escape(str(job["reason"]))}</p>'
                     for job in found['failed_jobs'])
    failed += ''.join(f'<p class="bad">{html.escape(line)}</p>' for line in of_earlier_run(city))
    return f'''<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>City: {html.escape(city.output.name)}</title><style>{STYLE}</style></head>
<body><h1>{html.escape(city.output.name)}</h1>
<p>{good} of {len(found['drives'])} drives are in the city, with {found['loops_between_drives']} loops between drives from
{found['chunks']} chunks. {link(city, 'city/report.html', 'Report of the whole map')}</p>{failed}
{picture(city)}
<h2>Drives</h2><table><tr><th>drive</th><th>result</th><th>key frames</th><th>loops to others</th></tr>{drives}</table>
<h2>Products</h2><ul>{files}</ul>
<h2>What failed</h2>{failures(city)}
<h2>Time</h2><table><tr><th>stage</th><th>jobs</th><th>time</th><th>processor time</th><th>largest memory</th><th>hosts</th></tr>
{stages}</table></body></html>
'''


def write_report(city):
    """Writes report.json and report.html of what is there now."""
    found = figures(city)
    city.make_folder()
    write_json(city.output / 'report.json', found)
    part = city.output / f'.report.html.{os.getpid()}.part'
    part.write_text(page(city, found))
    os.replace(part, city.output / 'report.html')
