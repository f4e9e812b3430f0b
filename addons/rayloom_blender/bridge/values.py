# SPDX-License-Identifier: GPL-3.0-or-later
"""What functions for shader nodes share: records → links, sockets → inputs."""

from .links import socket_of


def link_to(graph, record, output=None):
    """The value of a new record."""
    link = {"node": graph.add(record)}
    if output:
        link["output"] = output
    return link


def input_value(graph, node, name, path):
    """What the socket of that name gives."""
    socket = socket_of(node, name)
    return 0.0 if socket is None else graph.value(socket, path)


def fac_or_color(out):
    """The file's name of a texture's output."""
    return "fac" if out.name in {"Fac", "Factor", "Value"} else "color"
