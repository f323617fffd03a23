"""QIF 3 results: measured point features, joined by ids with their nominals (ANSI/DMSC QIF 3.0, ISO 23952)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from xml.sax import SAXParseException

import numpy as np

from compensator.devices.numbers import MM_IN, number
from compensator.devices.readings import SURFACE, DeviceFile, DeviceReadings, readings
from compensator.devices.xml_tree import Element, parsed
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, WARNING, Finding

NAME = "qif"
_MEASURED, _ITEM, _NOMINAL = "FeatureMeasurement", "FeatureItem", "FeatureNominal"
_POINT = re.compile(r"(?:Edge|Surface)?PointFeatureMeasurement$")
AGREES = 2e-3  # unit of the file: locations are often rounded to two decimals


@dataclass(frozen=True)
class _Ids:
    """Elements of a file that others refer to, by their id."""

    by_id: Mapping[str, Element]

    def of(self, file: DeviceFile, holder: Element, reference: str) -> Element:
        """What ``reference`` of an element points at."""
        key = holder.words(reference)
        found = self.by_id.get(key)
        if found is None:
            what = f"id {key!r}, which no element has" if key else "nothing"
            raise DeviceError(f"{file.label}: line {holder.line}: {holder.tag} {reference} is {what}; export again")
        return found


def recognised(file: DeviceFile) -> bool:
    """By its document element."""
    return "<QIFDocument" in file.text[:4000]


def read(file: DeviceFile) -> DeviceReadings:
    """The measured points of a file, in its order; a set of results is a group.

    Raises:
        DeviceError: no XML, no measured point, an id without an element, a location or normal that is no three numbers.
    """
    root = _document(file)
    ids = _Ids({key: e for e in root.walk() if (key := e.attributes.get("id"))})
    values = _profile_values(file, root)
    found: list[tuple[Element, str, Element, str, np.ndarray, np.ndarray]] = []
    left: Counter[str] = Counter()
    for results in root.find_all("MeasurementResults"):
        for measured in (e for e in results.walk() if e.tag.endswith(_MEASURED)):
            if not _POINT.match(measured.tag) or measured.child("Location") is None:
                left[measured.tag.removesuffix(_MEASURED)] += 1
                continue
            item = ids.of(file, measured, f"{_ITEM}Id")
            nominal = ids.of(file, item, f"{_NOMINAL}Id")
            group = results.attributes.get("id", "")
            name = item.words("FeatureName")
            location = _three(file, measured, "Location")
            found.append((measured, name, nominal, group, location, _three(file, nominal, "Normal")))
    if not found:
        kinds = ", ".join(f"{n} {what}" for what, n in left.items()) or "no measured feature"
        why = f"no measured point with a location in it ({kinds}); export results with point features"
        raise DeviceError(f"{file.label}: {why}")
    place = np.array([_three(file, nominal, "Location") for _, _, nominal, _, _, _ in found])
    measured_at, normal = np.array([f[4] for f in found]), np.array([f[5] for f in found])
    deviation = np.einsum("nk,nk->n", measured_at - place, normal)
    items = {e.attributes.get("id") for e in root.walk() if e.tag.endswith("PointFeatureItem")}
    unmeasured = len(items - {f[0].words(f"{_ITEM}Id") for f in found})
    told = [values.get(e.attributes.get("id", "")) for e, *_ in found]
    return readings(
        file,
        NAME,
        kind=SURFACE,
        line=[f[0].line for f in found],
        to_mm=_unit(file, root),
        name=[f[1] for f in found],
        group=[f[3] for f in found],
        numbers={"nominal": place, "measured": measured_at, "normal": normal},
        findings=(
            *_left_out(file, left, unmeasured),
            *_disagreeing(file, found=[f[0].line for f in found], deviation=deviation, told=told),
        ),
    )


def _document(file: DeviceFile) -> Element:
    if "<!DOCTYPE" in file.text or "<!ENTITY" in file.text:
        raise DeviceError(f"{file.label}: has a document type, which QIF files have not; export it again")
    try:
        return parsed(file.text)
    except SAXParseException as e:
        why = f"is not complete XML: {e.getMessage()}"
        raise DeviceError(f"{file.label}: line {e.getLineNumber()}: {why}; export it again") from e


def _unit(file: DeviceFile, root: Element) -> float | None:
    """mm in the unit of the file: by its factor to metres, else by its name."""
    unit = next(iter(root.find_all("PrimaryUnits")), None)
    linear = None if unit is None else unit.child("LinearUnit")
    if linear is None:
        return None
    factor = next(iter(linear.find_all("Factor")), None)
    if factor is not None:
        size = number(factor.text.strip(), file.label, factor.line, "the factor of the unit of length")
        if not 1e-7 < size < 10:
            why = f"a unit of length of {size:g} m; expected that of mm (0.001) or inch (0.0254)"
            raise DeviceError(f"{file.label}: line {factor.line}: {why}")
        return round(size * 1e3, 9)
    name = linear.words("UnitName").lower()
    if name and name not in MM_IN:
        raise DeviceError(f"{file.label}: line {linear.line}: unit {name!r} without a factor; expected mm, inch, m")
    return MM_IN.get(name)


def _three(file: DeviceFile, holder: Element, tag: str) -> np.ndarray:
    element = holder.child(tag)
    words = [] if element is None else element.text.split()
    line = holder.line if element is None else element.line
    if len(words) != 3:
        shown = "is missing" if element is None else f"is {' '.join(words)[:40]!r}"
        raise DeviceError(f"{file.label}: line {line}: {tag} of {holder.tag} {shown}, expected three numbers")
    return np.array([number(w, file.label, line, f"{tag} of {holder.tag}") for w in words])


def _profile_values(file: DeviceFile, root: Element) -> dict[str, list[float]]:
    """Deviations that the file itself has: id of a measured feature -> values of its point profiles."""
    out: dict[str, list[float]] = {}
    for e in root.find_all("PointProfileCharacteristicMeasurement"):
        ids, value = e.child("FeatureMeasurementIds"), e.child("Value")
        if ids is not None and value is not None:
            for one in ids.children:
                told = number(value.text.strip(), file.label, value.line, "Value of a point profile")
                out.setdefault(one.text.strip(), []).append(told)
    return out


def _left_out(file: DeviceFile, left: Counter[str], unmeasured: int) -> Iterator[Finding]:
    if left:
        kinds = ", ".join(f"{n} {what}" for what, n in left.items())
        what = f"{left.total()} measured features are no points of a surface, left out: {kinds}"
        yield Finding(NOTE, file.label, what)
    if unmeasured > 0:
        yield Finding(WARNING, file.label, f"{unmeasured} points of the plan have no measurement in this file")


def _disagreeing(
    file: DeviceFile, *, found: list[int], deviation: np.ndarray, told: Iterable[list[float] | None]
) -> Iterator[Finding]:
    """Points whose deviation is none of those that the file has for them."""
    for line, own, values in zip(found, deviation.tolist(), told, strict=True):
        if values and min(abs(own - v) for v in values) > AGREES:
            what = "the deviation along the normal is not the value of its point profile: the location counts"
            yield Finding(WARNING, f"{file.label}:{line}", what)
