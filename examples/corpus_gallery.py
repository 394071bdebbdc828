"""The gallery of the corpus: docs/stress_failures.md, and the film strips that it lacks.

    python examples/corpus_gallery.py [NAME...]

Renders the cases without a picture, and those that are named, and writes the page anew. A strip is
of the version that failed: that of a case that is fixed since is not made again unless named.
"""

import argparse
import tempfile
from pathlib import Path

import cv2

from pjpdaf.presets.names import DEFAULT_PRESET
from reports.page.episode_tables import episode_tables
from reports.pictures.resize import resized
from reports.run.load import load, read_film
from reports.run.rows import rows_of
from reports.run.save import RunInfo, save
from reports.stress.strips import sheet, strip
from reports.words import MEASURE_WORDS
from scenarios.play.play import play_complete
from scenarios.spec.corpus_case import corpus_files
from scenarios.stress.case_file import case_of, load_case, system_of

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, PICTURES = DOCS / "stress_failures.md", DOCS / "pictures" / "stress"
WIDTH_PX, JPEG_QUALITY = 900, 75


def film_strip(record):
    """The strip of a corpus case, rendered and tracked anew: a picture (h, w, 3) BGR."""
    job = case_of(record).job(system_of(record), label=record.name, film=True)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        save(out, [rows_of(play_complete(job))], RunInfo("run", record.detector, record.tracker))
        run = load(out)
        (tables,) = episode_tables(run)
        (film,) = (read_film(run, entry["file"]) for entry in run.meta["films"])
        return resized(sheet(strip(tables, film, record.event)), WIDTH_PX)


def entry(record):
    """A case's paragraph and its picture."""
    since = " (fixed since)" if record.status == "fixed" else ""
    note = record.note[:1].upper() + record.note[1:]
    return (
        f"**{record.name}**{since}: {record.family}, {MEASURE_WORDS[record.event]}, "
        f"ρ {record.rho:.2f}. {note}.\n\n![{record.name}](pictures/stress/{record.name}.jpg)\n"
    )


def page(records):
    """The page; its first lines, up to the first heading, stay."""
    text = PAGE.read_text(encoding="utf-8")
    parts = [text[: text.index("\n## ")].rstrip() + "\n"]
    for tracker in sorted({record.tracker for record in records}):
        later = "Pictures and figures are of the version that failed. "
        later += "A case that is fixed no longer fails, and CI plays it.\n"
        parts.append(f"## Failures of `{tracker}`\n")
        parts += [later] if tracker == DEFAULT_PRESET else []
        parts += [entry(record) for record in records if record.tracker == tracker]
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="cases to render although they have a picture")
    names = parser.parse_args().names
    records = [load_case(path) for path in corpus_files()]
    for record in records:
        target = PICTURES / f"{record.name}.jpg"
        if record.name in names or not target.exists():
            quality = (cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY)
            cv2.imwrite(str(target), film_strip(record), quality)
            print(target, flush=True)
    PAGE.write_text(page(records), encoding="utf-8")


if __name__ == "__main__":
    main()
