"""Times frames inside a program that script/scoreboard runs."""
import time

LONG_ENOUGH_MS = 8000


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
