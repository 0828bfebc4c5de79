"""The address space of the OPC UA server: nodes for tags, and their values.

asyncua's services would search all nodes in a folder for each new one, so this module creates the nodes
itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from importlib import import_module
from typing import Any

from scanrack.io_images.enip.listing import Kind

from ..tag_servers.database import Database
from ..tag_servers.variables import ELEMENTS_MOST, VARIABLES_MOST, Leaf, TagGroup, TagTree, Variable
from .opcua_library import status, ua

TYPES: Mapping[str, str] = {
    "BOOL": "Boolean",
    "SINT": "SByte",
    "INT": "Int16",
    "DINT": "Int32",
    "LINT": "Int64",
    "USINT": "Byte",
    "UINT": "UInt16",
    "UDINT": "UInt32",
    "DWORD": "UInt32",
    "ULINT": "UInt64",
    "REAL": "Float",
    "LREAL": "Double",
    "STRING": "String",
}
"""OPC UA types by tag type."""

ROOT = "Tags"
"""Name of the node that contains all tags."""


class TagNode:
    """The node of a variable.

    Attributes:
        attribute: asyncua's value attribute of the node.
        data: bytes of the current value, or None before the first read.
    """

    def __init__(self, variable: Variable, node_id: Any, attribute: Any) -> None:
        self.variable, self.node_id, self.attribute = variable, node_id, attribute
        self.data: bytes | None = None

    @property
    def shape(self) -> tuple[Kind, tuple[int, ...]]:
        """The type and dimensions of the variable."""
        return self.variable.kind, self.variable.dims


class TagSpace:
    """The nodes of all tags.

    Args:
        space: asyncua's address space.
        namespace: index of the tags' namespace.
        title: name of the rack.

    Attributes:
        nodes: nodes of variables, by identifier.
    """

    def __init__(self, space: Any, namespace: int, title: str) -> None:
        self._asyncua_nodes: Any = import_module("asyncua.server.address_space")
        self._space, self._namespace, self._title = space, namespace, title
        self._node_ids: list[Any] = []
        self.nodes: dict[Any, TagNode] = {}
        ids = ua.ObjectIds
        type_ids = (ids.FolderType, ids.BaseObjectType, ids.BaseDataVariableType)
        self._folder, self._object, self._variable = map(ua.NodeId, type_ids)
        references = (ids.HasComponent, ids.HasTypeDefinition, ids.Organizes)
        self._component, self._definition, self._organizes = map(ua.NodeId, references)
        self._shared_attributes: dict[tuple[str, Any], Any] = {}
        self._shared_references: dict[tuple[Any, Any, bool], Any] = {}

    async def show(self, database: Database) -> None:
        """Show a program's tags; the tags of an edited program replace the earlier ones.

        Subscriptions to a tag continue if it still exists.
        """
        nodes_before = self.nodes
        self._clear()
        objects = ua.NodeId(ua.ObjectIds.ObjectsFolder)
        root = self._add(objects, ROOT, self._title, self._folder, self._organizes)
        self._add_all(root, TagTree(database).roots())
        self._add_elements()
        for node_id, old_node in nodes_before.items():
            new_node = self.nodes.get(node_id)
            if new_node is None or new_node.shape != old_node.shape:
                await self._notify_deletion(old_node)
            else:
                new_node.attribute.datachange_callbacks.update(old_node.attribute.datachange_callbacks)

    def _clear(self) -> None:
        """Remove all nodes of tags, and the references to them."""
        objects = self._space[ua.NodeId(ua.ObjectIds.ObjectsFolder)]
        own_ids = set(self._node_ids)
        objects.references[:] = [
            reference for reference in objects.references if reference.NodeId not in own_ids
        ]
        for node_id in self._node_ids:
            del self._space[node_id]
        self._node_ids, self.nodes = [], {}
        self._shared_references.clear()

    async def _notify_deletion(self, node: TagNode) -> None:
        """Notify all subscriptions to a tag that the tag no longer exists."""
        deleted = ua.DataValue(StatusCode=status("BadNodeIdUnknown"))
        for handle, call in list(node.attribute.datachange_callbacks.items()):
            await call(handle, deleted)

    def _add_all(self, parent: Any, items: Iterator[Leaf | TagGroup]) -> None:
        """Add the nodes of groups and variables under a parent, up to `VARIABLES_MOST` variables."""
        for item in items:
            if len(self.nodes) >= VARIABLES_MOST:
                return
            if isinstance(item, TagGroup):
                self._add_all(self._add(parent, item.path, item.name, self._object), item.items())
            else:
                self._add_variable(parent, item)

    def _add_elements(self) -> None:
        """Add the elements of short arrays as child nodes, up to the maximum number of nodes."""
        for array in list(self.nodes.values()):
            space_left = VARIABLES_MOST - len(self.nodes)
            if array.variable.dims and array.variable.count <= min(ELEMENTS_MOST, space_left):
                for leaf in array.variable.elements():
                    self._add_variable(array.node_id, leaf)

    def _add_variable(self, parent: Any, leaf: Leaf) -> None:
        """Add the node of a variable; its value is missing until the first read."""
        variable = leaf.variable
        node_id = self._add(parent, variable.path, leaf.name, self._variable, is_variable=True)
        access = ua.AccessLevel.CurrentRead.mask
        if variable.writable:
            access |= ua.AccessLevel.CurrentWrite.mask
        attributes = self._space[node_id].attributes
        kind = getattr(ua.ObjectIds, TYPES[variable.type_name])
        attributes[ua.AttributeIds.DataType] = self._shared("NodeId", ua.NodeId(kind))
        attributes[ua.AttributeIds.ValueRank] = self._shared("Int32", len(variable.dims) or -1)
        for attribute in (ua.AttributeIds.AccessLevel, ua.AttributeIds.UserAccessLevel):
            attributes[attribute] = self._shared("Byte", access)
        attributes[ua.AttributeIds.Historizing] = self._shared("Boolean", False)
        attributes[ua.AttributeIds.MinimumSamplingInterval] = self._shared("Double", 0.0)
        if variable.dims:
            sizes = ua.Variant(list(variable.dims), ua.VariantType.UInt32, is_array=True)
            attributes[ua.AttributeIds.ArrayDimensions] = self._attribute(sizes)
        value = self._asyncua_nodes.AttributeValue(
            ua.DataValue(StatusCode=status("BadWaitingForInitialData"))
        )
        attributes[ua.AttributeIds.Value] = value
        self.nodes[node_id] = TagNode(variable, node_id, value)

    def _add(
        self,
        parent: Any,
        path: str,
        name: str,
        kind: Any,
        reference: Any = None,
        *,
        is_variable: bool = False,
    ) -> Any:
        """Add a node under a parent, by default with a HasComponent reference; return its identifier."""
        reference_type = self._component if reference is None else reference
        node_id = ua.NodeId(path, self._namespace)
        browse_name, text = ua.QualifiedName(name, self._namespace), ua.LocalizedText(name)
        node_class = ua.NodeClass.Variable if is_variable else ua.NodeClass.Object
        node = self._asyncua_nodes.NodeData(node_id)
        node.attributes = {
            ua.AttributeIds.NodeId: self._attribute(ua.Variant(node_id, ua.VariantType.NodeId)),
            ua.AttributeIds.NodeClass: self._shared("Int32", int(node_class)),
            ua.AttributeIds.BrowseName: self._attribute(
                ua.Variant(browse_name, ua.VariantType.QualifiedName)
            ),
            ua.AttributeIds.DisplayName: self._attribute(ua.Variant(text, ua.VariantType.LocalizedText)),
            ua.AttributeIds.WriteMask: self._shared("UInt32", 0),
            ua.AttributeIds.UserWriteMask: self._shared("UInt32", 0),
        }
        if not is_variable:
            node.attributes[ua.AttributeIds.EventNotifier] = self._shared("Byte", 0)
        node.references = [
            self._reference(kind, self._definition),
            self._reference(parent, reference_type, is_forward=False),
        ]
        self._space[node_id] = node
        self._space[parent].references.append(self._described(node_id, reference_type, True))
        self._node_ids.append(node_id)
        return node_id

    def _reference(self, target: Any, reference_type: Any, *, is_forward: bool = True) -> Any:
        """Return a reference that many nodes share: to their type, or back to their parent."""
        key = target, reference_type, is_forward
        if key not in self._shared_references:
            self._shared_references[key] = self._described(*key)
        return self._shared_references[key]

    def _described(self, target: Any, reference_type: Any, is_forward: bool) -> Any:
        """Return a reference that includes the names of its target, for browsing."""
        node, ids = self._space[target], ua.AttributeIds
        names = (ids.BrowseName, ids.DisplayName, ids.NodeClass)
        browse_name, text, node_class = (node.attributes[attribute].value.Value.Value for attribute in names)
        kinds = (
            reference
            for reference in node.references
            if reference.ReferenceTypeId == self._definition and reference.IsForward
        )
        return ua.ReferenceDescription(
            ReferenceTypeId=reference_type,
            IsForward=is_forward,
            NodeId=target,
            BrowseName=browse_name,
            DisplayName=text,
            NodeClass=ua.NodeClass(node_class),
            TypeDefinition=next((reference.NodeId for reference in kinds), ua.NodeId()),
        )

    def _shared(self, kind: str, value: Any) -> Any:
        """Return an attribute that many nodes share."""
        if (kind, value) not in self._shared_attributes:
            self._shared_attributes[kind, value] = self._attribute(ua.Variant(value, ua.VariantType[kind]))
        return self._shared_attributes[kind, value]

    def _attribute(self, variant: Any) -> Any:
        return self._asyncua_nodes.AttributeValue(ua.DataValue(variant))

    # --- values

    async def store(self, nodes: Iterable[TagNode], results: Iterable[bytes | None]) -> None:
        """Store values that were read at one instant; a tag with None was not read, and keeps its value."""
        now = datetime.now(UTC)
        for node, data in zip(nodes, results, strict=True):
            if data is None:
                continue
            value = self._value_of(node.variable, data, now)
            if data == node.data:  # only a new timestamp: subscriptions get no notification
                node.attribute.value = value
                continue
            node.data = data
            await self._space.write_attribute_value(node.node_id, ua.AttributeIds.Value, value)

    def _value_of(self, variable: Variable, data: bytes, now: datetime) -> Any:
        """Return the value of a variable's bytes, with `now` as both timestamps."""
        kind = ua.VariantType[TYPES[variable.type_name]]
        dims = list(variable.dims) if len(variable.dims) > 1 else None
        variant = ua.Variant(variable.value_in(data), kind, dims, bool(variable.dims))
        return ua.DataValue(variant, SourceTimestamp=now, ServerTimestamp=now)
