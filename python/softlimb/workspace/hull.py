"""The convex hull of places of the tip."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["convex_hull"]

_FLAT = 1e-12  # of the widest spread of the points; a thinner cloud is flat but for rounding and has no hull


def convex_hull(points: NDArray[np.float64]) -> Any:
    """Convex hull of points, moved so that their mean is the origin.

    Parameters
    ----------
    points : array, shape (N, 3)
        [m]

    Returns
    -------
    scipy.spatial.ConvexHull, or None
        Its ``points`` are the moved ones. None for fewer than four points, and for points in one plane.

    Raises
    ------
    ModuleNotFoundError
        scipy is missing.
    """
    try:
        from scipy.spatial import ConvexHull  # type: ignore[import-untyped, unused-ignore]
    except ModuleNotFoundError:
        raise ModuleNotFoundError("the hull of a workspace needs scipy: pip install 'softlimb[workspace]'") from None
    if len(points) < 4:
        return None
    centred = points - points.mean(axis=0)
    widths = np.linalg.svd(centred, compute_uv=False)
    return ConvexHull(centred) if widths[-1] > _FLAT * widths[0] else None
