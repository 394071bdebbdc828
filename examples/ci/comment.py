"""Put a Markdown file into a comment of the pull request (GitHub) or merge request (GitLab).

    python comment.py runs/tracking/summary.md

A comment of an earlier run is replaced. Which forge it is, and where, comes from the variables that
its jobs have; the token from GITHUB_TOKEN or GITLAB_TOKEN. Needs Python alone. Where the job is of
no pull request, or there is no token (such as a pull request from a fork), it says so and ends
with 0: a comment is no verdict.
"""

from __future__ import annotations

import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.error import HTTPError, URLError
from urllib.parse import quote
from urllib.request import Request, urlopen

MARKER = "<!-- pjpdaf-bench {name} -->"  # the first line of a comment, by which it is known
PAGE = 100  # comments a request
PAGES = 50


@dataclass(frozen=True)
class Thread:
    """The comments of a pull request.

    comments: the address that lists them and takes new ones; one: the address before a comment's
    number; method: the verb that replaces a comment; headers: with the token.
    """

    comments: str
    one: str
    method: str
    headers: dict[str, str]


def thread() -> Thread | str:
    """The thread of this job's pull request, or why there is none."""
    env = os.environ
    if "GITHUB_API_URL" in env:
        event = json.loads(Path(env["GITHUB_EVENT_PATH"]).read_text(encoding="utf-8"))
        number = event.get("pull_request", {}).get("number")
        if number is None:
            return "not a pull request"
        if not env.get("GITHUB_TOKEN"):
            return "no GITHUB_TOKEN"
        issues = f"{env['GITHUB_API_URL']}/repos/{env['GITHUB_REPOSITORY']}/issues"
        headers = {
            "Authorization": f"Bearer {env['GITHUB_TOKEN']}",
            "Accept": "application/vnd.github+json",
        }
        return Thread(f"{issues}/{number}/comments", f"{issues}/comments", "PATCH", headers)
    if "CI_API_V4_URL" in env:
        if not env.get("CI_MERGE_REQUEST_IID"):
            return "not a merge request"
        if not env.get("GITLAB_TOKEN"):
            return "no GITLAB_TOKEN (a project access token with scope api)"
        project = quote(env["CI_PROJECT_ID"], safe="")
        notes = (
            f"{env['CI_API_V4_URL']}/projects/{project}"
            f"/merge_requests/{env['CI_MERGE_REQUEST_IID']}/notes"
        )
        return Thread(notes, notes, "PUT", {"PRIVATE-TOKEN": env["GITLAB_TOKEN"]})
    return "neither GitHub nor GitLab"


def asked(address: str, headers: dict[str, str], method: str = "GET", body: Any = None) -> Any:
    """The JSON that an address answers."""
    data = None if body is None else json.dumps(body).encode()
    request = Request(address, data, {**headers, "Content-Type": "application/json"}, method=method)
    with urlopen(request, timeout=30) as answer:
        return json.load(answer)


def earlier(place: Thread, marker: str) -> int | None:
    """The number of the comment that an earlier run wrote, None where there is none."""
    for page in range(1, PAGES + 1):
        comments = asked(f"{place.comments}?per_page={PAGE}&page={page}", place.headers)
        for comment in comments:
            if comment["body"].startswith(marker):
                return int(comment["id"])
        if len(comments) < PAGE:
            break
    return None


def main(path: str) -> str:
    """Write the comment; returns what was done, or why nothing was."""
    place = thread()
    if isinstance(place, str):
        return f"no comment: {place}"
    marker = MARKER.format(name=Path(path).parent.as_posix())
    body = {"body": f"{marker}\n{Path(path).read_text(encoding='utf-8')}"}
    try:
        number = earlier(place, marker)
        if number is None:
            asked(place.comments, place.headers, "POST", body)
            return "comment written"
        asked(f"{place.one}/{number}", place.headers, place.method, body)
    except HTTPError as error:
        return f"no comment: {error.code} {error.reason} (may the token write comments?)"
    except (URLError, TimeoutError) as error:
        return f"no comment: {error}"
    return "comment replaced"


if __name__ == "__main__":
    print(main(sys.argv[1]), file=sys.stderr)
