"""Flattening of nested models: names in a model `arm` become `arm::...`.

A name in a model may refer to its links, joints, frames and models, and to those inside of these.
"""

from __future__ import annotations

from dataclasses import replace

from ...description.geometry import Transform, rpy_of
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import SCOPE, WORLD, ModelPoses
from .versions import MODEL
from .vocabulary import WELD

MERGE = "merge"  # attribute of a model whose elements are merged into the model around it
_PLACEMENT = "__placement__"
_NAMED = ("link", "joint", "frame")
ENDS = ("parent", "child", "gearbox_reference_body")  # elements whose text is a name
REFERENCES = ("relative_to", "attached_to", "expressed_in")


def flat_model(xml: XmlReader, model: LocatedElement) -> LocatedElement:
    """A flattened copy of a model."""
    flat = replace(model, children=[])
    for child in model.children:
        if child.tag == "model":
            flat.children.extend(_opened(xml, child))
        else:
            flat.children.append(child)
    return flat


def placed(xml: XmlReader, model: LocatedElement) -> Transform:
    """Pose of the model frame in its placement frame.

    Args:
        xml: the file.
        model: a flattened model.
    """
    name = model.get("placement_frame")
    if name in ("", MODEL):
        return Transform()
    return ModelPoses(xml, model).resolve(name, model).inverse()


def has_joints(model: LocatedElement) -> bool:
    """Whether a model, or a model in it, has joints."""
    return bool(model.all("joint")) or any(map(has_joints, model.all("model")))


def _opened(xml: XmlReader, model: LocatedElement) -> list[LocatedElement]:
    """The elements of a model, and its frame, with their names in the model around it."""
    name = xml.name(model, "models")
    inner = flat_model(xml, model)
    prefix = f"{name}{SCOPE}"
    frame = f"{prefix}{MODEL}"
    if model.get(MERGE):
        prefix = ""
        frame = f"_merged__{name}{MODEL}"
    renaming = _Renaming(prefix, frame)
    elements = renaming.model_frames(xml, inner)
    for element in inner.children:
        if element.tag in _NAMED:
            elements.append(renaming.named(element))
        elif element.tag == WELD:
            elements.append(renaming.renamed(element))
        elif ":" in element.tag:
            elements.append(element)
    return elements


class _Renaming:
    """Renames elements of a model to their names in the model around it.

    Args:
        prefix: prefix of names.
        frame: name of the frame of the model.
    """

    def __init__(self, prefix: str, frame: str) -> None:
        self.prefix = prefix
        self.frame = frame

    def name(self, name: str) -> str:
        """The new name for a name in the model."""
        if name in ("", MODEL):
            return self.frame
        if name == WORLD:
            return WORLD
        return f"{self.prefix}{name}"

    def named(self, element: LocatedElement) -> LocatedElement:
        """A copy of a link, joint or frame with its new name and pose reference."""
        renamed = self.renamed(element)
        renamed.attributes["name"] = f"{self.prefix}{element.get('name')}"
        if element.tag == "frame":
            renamed.attributes["attached_to"] = self.name(element.get("attached_to"))
        if element.tag == "link":
            pose = renamed.first("pose")
            if pose is None:
                pose = LocatedElement("pose", {}, element.line, file=element.file)
                renamed.children.append(pose)
            pose.attributes["relative_to"] = pose.get("relative_to") or self.frame
        return renamed

    def renamed(self, element: LocatedElement) -> LocatedElement:
        """A copy of an element in which all references are renamed."""
        children = [self.renamed(child) for child in element.children]
        copy = replace(element, attributes=dict(element.attributes), children=children)
        for attribute in REFERENCES:
            if element.get(attribute):
                copy.attributes[attribute] = self.name(element.get(attribute))
        if element.tag == "mimic":
            copy.attributes["joint"] = self.name(element.get("joint"))
        if element.tag in ENDS and element.text.strip():
            copy.text = self.name(element.text.strip())
        return copy

    def model_frames(self, xml: XmlReader, model: LocatedElement) -> list[LocatedElement]:
        """The frame elements of a model: its placement frame, if any, and the model frame."""
        pose = model.first("pose")
        if pose is None:
            pose = LocatedElement("pose", {}, model.line, file=model.file)
        attributes = {**pose.attributes, "relative_to": pose.get("relative_to") or MODEL}
        frames = [_frame(self.frame, replace(pose, attributes=attributes))]
        offset = placed(xml, model)
        if not offset.is_identity():
            placement = f"{self.frame}{_PLACEMENT}"
            frames[0].attributes["name"] = placement
            frames.append(_frame(self.frame, pose_element(offset, placement, model)))
        carrier = self.name(canonical_link(model))
        for frame in frames:
            frame.attributes["attached_to"] = carrier
        return frames


def canonical_link(model: LocatedElement) -> str:
    """The link that carries the model frame; empty if the model has no link."""
    first = model.first("link")
    if model.get("canonical_link") or first is None:
        return model.get("canonical_link")
    return first.get("name")


def pose_element(pose: Transform, relative_to: str, element: LocatedElement) -> LocatedElement:
    """A <pose> element with the line of another element."""
    numbers = [*pose.translation.tolist(), *rpy_of(pose.rotation).tolist()]
    text = " ".join(map(repr, numbers))
    attributes = {"relative_to": relative_to}
    return LocatedElement("pose", attributes, element.line, text=text, file=element.file)


def _frame(name: str, pose: LocatedElement) -> LocatedElement:
    attributes = {"name": name}
    return LocatedElement("frame", attributes, pose.line, [pose], file=pose.file)
