"""What the programs have in common that draw frames for script/scoreboard: their options, and how frames are timed."""
import argparse
import time

LONG_ENOUGH_MS = 8000


def pixels(text):
    """(width, height) of "640x360"."""
    width, height = map(int, text.split("x"))
    return width, height


def parser_of(program, description, picture=".png", size="640x360"):
    """The options that all of them have."""
    parser = argparse.ArgumentParser(prog=program, description=description)
    parser.add_argument("scene")
    parser.add_argument("-o", required=True, help=f"the {picture} to write")
    parser.add_argument("--size", type=pixels, default=size)
    parser.add_argument("--sky", help="a lat-long .hdr; programs without an environment take its mean as constant light")
    parser.add_argument("--frames", type=int, default=0, help="how many frames are timed after the first")
    return parser


def timed(draw, count):
    """Draws frames 1 to `count`, each with another number, fewer where they are slow: wall and processor time of each in ms.
    Processor time is that of all threads of this process."""
    wall, processor = [], []
    for number in range(1, count + 1):
        at, spent = time.perf_counter(), time.process_time()
        draw(number)
        wall.append(1000 * (time.perf_counter() - at))
        processor.append(1000 * (time.process_time() - spent))
        if sum(wall) > LONG_ENOUGH_MS:
            break
    return {"frames_ms": wall, "processor_ms": processor}
