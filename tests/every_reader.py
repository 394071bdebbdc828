"""Pages for every reader: WCAG 2.2 AA by axe-core, a desk, a phone in the dark, the keyboard."""

from importlib import resources

AXE = resources.files("axe_playwright_python") / "axe.min.js"
LEVELS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]
SCREENS = [(1440, 900, "light"), (390, 844, "dark")]
# What has the focus and a look of its own for it: an outline, or a shadow around.
UNSEEN = """() => { const at = document.activeElement, style = getComputedStyle(at);
  const ring = style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) > 0;
  const seen = at === document.body || ring || style.boxShadow !== 'none';
  return seen ? '' : at.outerHTML.slice(0, 120); }"""
MOVING = """() => document.getAnimations().filter(a => a.playState === 'running'
  && a.effect.getComputedTiming().duration > 1).length
  + [...document.querySelectorAll('video')].filter(v => !v.paused).length"""

# Words in which a line may end between a number and its "%"; commands are copied as they are.
PARTED = r"""() => { const found = [];
  const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (words.nextNode()) { const { textContent: text, parentElement: at } = words.currentNode;
    if (/\d %/.test(text) && !at.closest('code, script, style, svg')) found.push(text.trim()); }
  return found; }"""

PAPER_PX = {"width": 718, "height": 1047}  # of A4 without its margins
# Charts, drawings, pictures and coloured marks that paper lacks, cuts, or has empty.
UNPRINTED = r"""() => [...document.querySelectorAll('main svg.chart, main canvas, main img')]
  .filter(e => !e.closest('[hidden]')).filter(e => {
    const { width, height, right } = e.getBoundingClientRect();
    const blank = e.tagName === 'CANVAS' && !e.getContext('2d')
      .getImageData(0, 0, e.width, e.height).data.some(v => v > 0);
    return width < 40 || height < 20 || right > innerWidth + 1 || blank;
  }).concat([...document.querySelectorAll('main i, .spans button, .strip em')].filter(e => {
    const { backgroundColor: colour, printColorAdjust: kept } = getComputedStyle(e);
    return kept !== 'exact' && !/^rgba.*, 0\)$/.test(colour);
  })).map(e => e.outerHTML.slice(0, 120))"""


def widest(view, selector):
    """By how much the widest of these places is too narrow for what is in it [px]."""
    overflow = "places => Math.max(...places.map(p => p.scrollWidth - p.clientWidth))"
    return view.locator(selector).evaluate_all(overflow)


def violations(view):
    """What axe-core objects to, with all folds and columns open."""
    view.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    closed = ".more:not([aria-expanded=true])"
    view.evaluate(f"document.querySelectorAll('{closed}').forEach(b => b.click())")
    view.evaluate(AXE.read_text(encoding="utf-8"))
    found = view.evaluate(
        # Details of what is in order would take most of the time.
        "tags => axe.run(document, { runOnly: { type: 'tag', values: tags }, "
        "resultTypes: ['violations'] })",
        LEVELS,
    )
    assert len(found["passes"]) > 10  # it did look
    return [(v["id"], v["nodes"][0]["html"][:99]) for v in found["violations"]]


def unprinted(view):
    """What of the page's charts and pictures is not on paper as it should be."""
    view.set_viewport_size(PAPER_PX)
    view.emulate_media(media="print")
    view.evaluate("dispatchEvent(new Event('beforeprint'))")
    found = view.evaluate(UNPRINTED)
    view.evaluate("dispatchEvent(new Event('afterprint'))")
    view.emulate_media(media="screen")
    return found


def faults(view, stops=25):
    """What stands in any reader's way, on a desk by day and on a phone in the dark.

    A rule of WCAG that is broken; something wider than the screen; a line that may end between a
    number and its "%"; motion that a reader who prefers none still gets; a stop of the Tab key, of
    the first `stops`, that does not show; a chart or picture that is not printed.
    """
    found = []
    for width, height, scheme in SCREENS:
        view.set_viewport_size({"width": width, "height": height})
        view.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        here = [*violations(view)]
        if (over := view.evaluate("document.documentElement.scrollWidth") - width) > 0:
            here.append(("too wide", f"{over} px"))
        here += [("parted", words) for words in view.evaluate(PARTED)[:5]]
        if moving := view.evaluate(MOVING):
            here.append(("moves", str(moving)))
        found += [(width, scheme, *fault) for fault in here]
    view.evaluate("scrollTo(0, 0); document.activeElement.blur()")
    for _ in range(stops):
        view.keyboard.press("Tab")
        if unseen := view.evaluate(UNSEEN):
            found.append(("no focus to see", unseen))
    return found + [("not printed", what) for what in unprinted(view)]
