"""The tags that a job's servers offer to clients, before the job runs."""

from __future__ import annotations

from scanrack.io_images.enip.listing import Listing
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.images import with_images

from ...load.loading import LoadedRack
from ...load.rungs import is_rungs


def listing_of_job(job: LoadedRack) -> Listing:
    """Return the tags of a job's program and the images of its slots; only the images if it has no rungs.

    Raises:
        ValueError: the program can't be built.
    """
    tags = Listing(())
    if is_rungs(job.logic):
        from scanrack.ladder.state.listing import listing_of

        tags = listing_of(job.logic.build().layout)
    return with_images(tags, job.spec.words, job.spec.server.profile)


def database_of_job(job: LoadedRack) -> Database:
    """Return the tags of a job with the tags that its rack file makes writable; see `listing_of_job`."""
    return Database(listing_of_job(job), job.spec.server.writable)
