"""Choice of the robot's model in an SDFormat file, and its pose in the world."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ...description.geometry import Transform
from ...errors import DescriptionError, InputError
from ...ground.file_options import FileOptions
from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .includes import Includes
from .nesting import ENDS, REFERENCES, flat_model, has_joints, placed, pose_element
from .poses import SCOPE, WORLD, ModelPoses
from .versions import MODEL, Version, upgrade
from .vocabulary import check_model, check_world

_YES = ("true", "1")
_MAX_LISTED = 20  # names in a message


@dataclass(frozen=True, eq=False)
class Chosen:
    """The robot of a file.

    Attributes:
        model: the model, flattened and converted to version 1.7.
        world: the world, or None.
    """

    model: LocatedElement
    world: LocatedElement | None


class Selection:
    """The models of a file, with included ones."""

    def __init__(self, xml: XmlReader, version: Version, options: FileOptions) -> None:
        self.xml = xml
        self.version = version
        self.name = options.model
        self.includes = Includes(xml, options)
        self.worlds = xml.root.all("world")
        self.models: list[Chosen] = [Chosen(model, None) for model in xml.root.all("model")]
        for chosen in self.models:
            upgrade(chosen.model, version)
            self.includes.open_model(chosen.model)
        for world in self.worlds:
            upgrade(world, version)
            self.includes.open_world(world)
            self.models.extend(Chosen(model, world) for model in world.all("model"))

    def chosen(self) -> Chosen:
        """The requested model, the only one with joints, or a whole world with joints.

        Raises:
            DescriptionError: none has joints, or several have.
            InputError: there is no model of the requested name.
        """
        chosen = self._named() if self.name else self._only()
        if chosen.model is chosen.world:
            return self._of_world(chosen.model)
        for child in self.xml.root.children:
            if child not in (chosen.model, chosen.world):
                self.xml.note(child, f"<{child.tag}> beside the model is left out")
        if chosen.world is None:
            return self._alone(chosen.model)
        return self._in_world(chosen.model, chosen.world)

    def _named(self) -> Chosen:
        worlds = [Chosen(world, world) for world in self.worlds]
        for chosen in (*self.models, *worlds):
            if chosen.model.get("name") == self.name:
                return chosen
        names = [chosen.model.get("name") for chosen in (*self.models, *worlds)]
        hint = suggestion(self.name, names)
        listed = ", ".join(names[:_MAX_LISTED])
        problem = f"{self.xml.file} has no model '{self.name}'{hint}; it has: {listed}"
        raise InputError(f"model: {problem}")

    def _only(self) -> Chosen:
        """The only movable model; a world with joints is one too."""
        for world in self.worlds:
            if world.all("joint"):
                return Chosen(world, world)
        moving = [chosen for chosen in self.models if _moves(chosen.model)]
        if len(moving) == 1:
            return moving[0]
        is_alone = len(self.models) == 1 and not self.includes.missing
        if not moving and is_alone:
            return self.models[0]
        for world in self.worlds:
            if moving and all(chosen.world is world for chosen in moving):
                return self._together(world, moving)
        raise self._undecided(moving)

    def _together(self, world: LocatedElement, moving: list[Chosen]) -> Chosen:
        """The world of several movable models."""
        names = [chosen.model.get("name") for chosen in moving]
        listed = ", ".join(names[:_MAX_LISTED])
        text = f"{len(names)} models with joints ({listed}) are taken together as one robot"
        text += f"; load(file, model='{names[0]}') or --model {names[0]} takes one of them"
        self.xml.note(world, text)
        return Chosen(world, world)

    def _undecided(self, moving: list[Chosen]) -> DescriptionError:
        problem = f"holds {len(moving)} models with joints"
        if moving:
            names = [chosen.model.get("name") for chosen in moving]
            listed = ", ".join(names[:_MAX_LISTED])
            problem += (
                f" ({listed}); name one of them: load(file, model='{names[0]}') or --model"
                f" {names[0]}"
            )
        else:
            problem = "holds no model with joints that is not <static>; expected one"
        for missing in self.includes.missing:
            problem += f"; it includes {missing}"
        return self.xml.error(self.xml.root, ("model",), problem)

    def _alone(self, model: LocatedElement) -> Chosen:
        """A model without a world."""
        pose = model.first("pose")
        if pose is not None and pose.get("relative_to") not in ("", WORLD):
            problem = f"relative_to of <pose> is '{pose.get('relative_to')}', and there is no world"
            raise self.xml.error(pose, ("models", model.get("name")), problem)
        flat = self._ready(model)
        offset = placed(self.xml, flat)
        if offset.is_identity():
            return Chosen(flat, None)
        return Chosen(self._moved(flat, ModelPoses(self.xml, flat).model @ offset), None)

    def _in_world(self, model: LocatedElement, world: LocatedElement) -> Chosen:
        """A model of a world, with its pose in the world."""
        check_world(self.xml, world)
        for other in world.all("model"):
            if other is not model:
                self.xml.note(other, f"model {other.get('name')} is left out")
        flat = self._ready(model)
        pose = model.first("pose")
        is_placed = pose is not None and pose.get("relative_to") not in ("", WORLD)
        if not is_placed and model.get("placement_frame") in ("", MODEL):
            return Chosen(flat, world)
        around = ModelPoses(self.xml, flat_model(self.xml, world))
        name = f"{model.get('name')}{SCOPE}{MODEL}"
        return Chosen(self._moved(flat, around.resolve(name, model)), world)

    def _of_world(self, world: LocatedElement) -> Chosen:
        """All models of a world as one robot, without static ones that nothing refers to."""
        check_world(self.xml, world)
        children: list[LocatedElement] = []
        for child in world.children:
            if child.tag == "model" and _is_static(child) and not _is_named(child, world):
                text = f"model {child.get('name')} is static and carries nothing; left out"
                self.xml.note(child, text)
                continue
            children.append(child)
            if child.tag == "model":
                self._check(child)
        flat = flat_model(self.xml, replace(world, children=children))
        return Chosen(replace(flat, tag="model"), world)

    def _ready(self, model: LocatedElement) -> LocatedElement:
        """A flattened model whose words are checked."""
        self._check(model)
        return flat_model(self.xml, model)

    def _check(self, model: LocatedElement) -> None:
        """Check the words of this file; included files are checked by their own version."""
        if not self.includes.is_opened(model):
            check_model(self.xml, self.includes.without_opened(model), self.version)

    def _moved(self, model: LocatedElement, pose: Transform) -> LocatedElement:
        """A model with another pose in the world."""
        children = [child for child in model.children if child.tag != "pose"]
        return replace(model, children=[pose_element(pose, "", model), *children])


def _moves(model: LocatedElement) -> bool:
    return has_joints(model) and not _is_static(model)


def _is_static(model: LocatedElement) -> bool:
    static = model.first("static")
    return static is not None and static.text.strip() in _YES


def _is_named(model: LocatedElement, world: LocatedElement) -> bool:
    """Whether anything of a world outside of a model refers to the model or to what is in it."""
    name = model.get("name")
    open_elements = [child for child in world.children if child is not model]
    while open_elements:
        element = open_elements.pop()
        open_elements.extend(element.children)
        words = [element.get(attribute) for attribute in REFERENCES]
        if element.tag in ENDS:
            words.append(element.text.strip())
        if any(word == name or word.startswith(f"{name}{SCOPE}") for word in words):
            return True
    return False
