#!/usr/bin/env python3
"""The picture of docs/benchmark.md: force error of each renderer in each family. Standard library only.

    picture.py SCORES.csv OUT.svg
"""
import csv
import html
import math
import sys

COLORS = ["#1b6ca8", "#d1495b", "#edae49", "#66a182", "#7a5195", "#6c757d", "#2e4057", "#8d6b94"]
LEFT, TOP, WIDTH, ROW = 110, 64, 560, 30
LOW, HIGH = -1, math.log10(400)  # powers of ten of the percent shown

with open(sys.argv[1], newline="") as file:
    rows = [row for row in csv.DictReader(file) if row["force_share"]]
families = list(dict.fromkeys(row["family"] for row in rows))
renderers = list(dict.fromkeys(row["renderer"] for row in rows))


def x_of(percent):
    power = min(max(math.log10(max(percent, 1e-9)), LOW), HIGH)
    return LEFT + WIDTH * (power - LOW) / (HIGH - LOW)


height = TOP + ROW * len(families) + 46
out = ['<svg xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" font-size="12"'
       f' viewBox="0 0 {LEFT + WIDTH + 30} {height}">',
       f'<rect width="{LEFT + WIDTH + 30}" height="{height}" fill="white"/>']
bottom = TOP + ROW * len(families)
for percent in (0.1, 1, 10, 100):
    x = x_of(percent)
    out.append(f'<line x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{bottom}" stroke="#cccccc"/>'
               f'<text x="{x:.1f}" y="{bottom + 16}" text-anchor="middle">{percent} %</text>')
out.append(f'<text x="{LEFT + WIDTH / 2}" y="{bottom + 36}" text-anchor="middle">'
           "error of the force, root mean square, in percent of the true force’s; 100 %: as no force at all</text>")
for i, renderer in enumerate(renderers):
    x, y = LEFT + 190 * (i % 3), 18 + 18 * (i // 3)
    out.append(f'<circle cx="{x}" cy="{y - 4}" r="5" fill="{COLORS[i % len(COLORS)]}"/>'
               f'<text x="{x + 10}" y="{y}">{html.escape(renderer)}</text>')
for j, family in enumerate(families):
    y = TOP + ROW * (j + 0.5)
    out.append(f'<text x="{LEFT - 10}" y="{y + 4}" text-anchor="end">{html.escape(family)}</text>'
               f'<line x1="{LEFT}" y1="{y}" x2="{LEFT + WIDTH}" y2="{y}" stroke="#eeeeee"/>')
    for i, renderer in reversed(list(enumerate(renderers))):
        shares = [float(row["force_share"]) for row in rows if (row["family"], row["renderer"]) == (family, renderer)]
        if shares:
            x, at = x_of(sum(shares) / len(shares)), y + 2.4 * (i - (len(renderers) - 1) / 2)
            out.append(f'<circle cx="{x:.1f}" cy="{at:.1f}" r="5" fill="{COLORS[i % len(COLORS)]}"/>')
out.append("</svg>\n")
with open(sys.argv[2], "w") as file:
    file.write("\n".join(out))
