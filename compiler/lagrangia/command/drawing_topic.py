"""The text of `lag help drawing`."""

from textwrap import fill

from lagrangia.language.figures import CHOICES, OPTIONS, WORDS

_HEAD = """\
A component says how it looks in a section of its own, as `energy` says how it moves. All of the library does; so can yours:

    model Fan
      parameter Integer blades = 3;
      parameter Length tip = 0.1 "as drawn";
      Frame hub;
    drawing
      for i in 1:blades loop
        line(hub, shift(turn(hub, i*120[deg]), {tip, 0}), style = "thick");
      end for;
      circle(hub, size = 0.3, fill = "white");
    end Fan;

A scene may have one as well. A place is a frame (a, shift(a, {x, y}), turn(a, phi)) or a position (a.r + {x, y}). Sizes are
lengths like all others, any expressions; those that are left out are symbols, whose size suits the picture: `size` and `offset`
count in those. A class that draws for itself does not draw what it inherits; an empty section draws nothing. A run reads none.
"""
_TAIL = """\
A hatch is drawn where the ground is: at a frame that moves, it is nothing. A rail runs through its base along `along`, as far as
the slider goes. An arrow in N is as long as the force is large, one in m as long as it says, one without unit shows a direction;
a curved_arrow in N.m is as long as the torque is large, one of an angle begins at the x axis of its frame. A label is a text, or
names whose symbols are written as by `lag equations`: label = k, label = {m, L}. Where the ends of a spring are bound to nothing,
`of` is what it is a function of, and they are found from it: zigzag(a, b, of = stretch), with Spring(stretch = block.s).

`lag draw` shows a scene at its start or --at T: forces by their directions, coordinates as arrows, what several things would
do in one place (blocks, discs, shafts that numbers alone tie) side by side along what joins them. `lag animate` writes one
HTML file that plays: space plays, arrows step, Home and End, + and - change the speed, L loops, T shows traces, N names, D
light or dark; times are those of the run's rows (--interval). --stroboscope N puts N positions into one picture,
--beside NAME=VALUE,... another run with these parameters and start values beside it, by thin lines; --beside k=1:5:1 several
(from:to:step, or linspace(1,5,9)), --beside FILE.csv those of a table, such as `lag sweep` writes. Impacts and switches have rows
of their own. Films are .gif, .webp, .mp4 (pip install imageio-ffmpeg) and .svg, which browsers play as they show any picture.

Drive trains, whose flanges have no places, are drawn along a shaft, from flange to flange: what stands between two shafts in one
row, what is beside it in the next. Dots are where a shaft branches; lines that cross without one are not connected; dashed lines
lead to housings. Long trains go on in further lines. All parts have their names, HingeFlange and SliderFlange those of joints
too; classes of one's own that extend one of the library look as it does, others are boxes. A mechanism is above the drive train
of its scene. Drive trains do not move: `lag draw` and `lag doc` show them, `lag animate` and `lag play` do not.

Scenes in space are drawn by solids: circles are thin discs, rings where they have no fill, or balls where they are symbols; boxes
are as high as they are deep; `along` is the axis of a cylinder. cuboid, cylinder, cone (about its centre of mass) and ball are of
space alone. --view=AZIMUTH,ELEVATION says from where it is seen, in degrees: up is against gravity. The page of `lag animate` is
turned by dragging, shifted by two fingers or with shift, zoomed by the wheel or by pinching; 0 1 2 3 are the usual views.
-o NAME.glb is binary glTF with the whole motion, for Blender, three.js and other viewers.

`lag play` writes one HTML file that computes, from the same tape by the same run time, compiled to WebAssembly: sliders for
parameters, start values and inputs, parts that can be dragged to where the motion starts, events at their exact times, and the
digits of `lag simulate` at the same --tolerance, by formulas that hold for all that sliders set. Inputs of -u FILE.csv go on over
time, until their slider is moved. Space runs, the right arrow steps, R goes back to the start; + - T N D as above. Scenes in
space are turned, shifted and zoomed as in the page of `lag animate`, but where a part is under the pointer: it is ringed, and
follows in the plane of view. Three sliders turn each attitude from where it starts. Without -o it is opened at once. It needs
zig, once for each version of the run time: pip install ziglang.
"""


def drawing_topic() -> str:
    """The words with what they take, from their table."""
    words = "\n".join(f"    {word.usage}" for word in WORDS.values())
    options = ", ".join(f"{name} = {' | '.join(CHOICES[name]) if name in CHOICES else kind}" for name, kind in OPTIONS.items())
    return f"{_HEAD}\n{words}\n\n{fill(f'And to any of them: {options}', 128)}\n\n{_TAIL}"
