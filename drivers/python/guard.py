"""Opens HDF5 files of unknown origin: all that a file may refer to is in the file, and no size exceeds what it stores.

HDF5 itself follows links and raw data into other files, and allocates what a shape claims. The whole file is
therefore walked once, before anything in it is read."""

import contextlib
import math
import os
import stat

import h5py
from h5py import h5a, h5d, h5ds, h5g, h5l, h5o, h5t, h5z

DEPTH_MOST = 32  # groups in groups; a cycle of links is deeper than any bound
DEFLATE_MOST = 1032  # of deflate: bytes out for a byte in (zlib, Technical Details)
LINK_LEAST = 8  # bytes of a file that a link takes: an object's address
TEXTS_AT_ONCE = 64  # a text may be as long as the file
FILTERS = {h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32}  # those without a plugin that keep the bound
LAYOUTS = (h5d.COMPACT, h5d.CONTIGUOUS, h5d.CHUNKED)
ONE = ("format", "format_version", "model", "method", "status", "units")  # attributes that have a single value


class Unsafe(Exception):
    """Refused content of a file: object and reason."""


def refuse(path, why):
    raise Unsafe(f"{path.decode(errors='replace')} {why}")


def look_at_storage(path, layout):
    """Its data are in this file, in a form that needs no plugin."""
    if layout.get_external_count() > 0:
        refuse(path, "has its data in other files; copy the data into this one")
    if layout.get_layout() not in LAYOUTS:
        refuse(path, "is spread over other files; copy the data into this one")
    filters = [layout.get_filter(i)[0] for i in range(layout.get_nfilters())]
    for number in filters:
        if number not in FILTERS:
            refuse(path, f"is packed by a filter that is not deflate ({number}); h5repack -f GZIP=4 packs it by deflate")
    return DEFLATE_MOST if h5z.FILTER_DEFLATE in filters else 1


def look_at_size(path, dataset, length):
    """A dataset without storage reads as its fill value, and may be as long as the file."""
    layout = dataset.get_create_plist()
    most = look_at_storage(path, layout)
    chunked = layout.get_layout() == h5d.CHUNKED
    size, stored = dataset.get_type().get_size(), dataset.get_storage_size()
    claimed = size * math.prod(dataset.shape or ())
    if claimed > 0 and chunked:  # a chunk is read whole
        claimed = max(claimed, size * math.prod(layout.get_chunk()))
    bound = most * stored if chunked else length
    if claimed > bound:
        refuse(path, f"{'is longer than its data' if chunked else 'has less data than its shape says'}: "
                     f"{claimed} bytes, at most {bound}")


def look_at_texts(path, dataset, length):
    """Each text is in the file once; texts that share one would be larger in memory than the file."""
    kind = dataset.get_type()
    if not isinstance(kind, h5t.TypeStringID) or not kind.is_variable_str() or len(dataset.shape or ()) != 1:
        return
    rows, total = h5py.Dataset(dataset), 0
    for start in range(0, dataset.shape[0], TEXTS_AT_ONCE):
        total += sum(len(value) for value in rows[start : start + TEXTS_AT_ONCE])
        if total > length:
            refuse(path, f"has more than {length} bytes of text, which is the length of the file")


def look_at_attributes(path, item):
    for name in ONE:
        if h5a.exists(item, name.encode()) and h5a.open(item, name.encode()).get_space().get_simple_extent_npoints() != 1:
            refuse(path, f"has an attribute '{name}' of several values; it must have one")


class Walk:
    """Every object that links lead to, by its address."""

    def __init__(self, file):
        self.length = os.path.getsize(file.filename)
        self.links = self.length // LINK_LEAST
        self.seen, self.datasets = set(), []
        self.group(b"", h5g.open(file.id, b"/"), 0)
        for path, dataset in self.datasets:
            self.scales(path, dataset)

    def group(self, path, group, depth):
        look_at_attributes(path or b"/", group)
        if depth > DEPTH_MOST:
            refuse(path[:60], f"... is a group in more than {DEPTH_MOST} groups, or in itself")
        for name in list(group):
            self.link(path + b"/" + name, group, name, depth)

    def link(self, path, group, name, depth):
        self.links -= 1
        if group.links.get_info(name).type != h5l.TYPE_HARD:
            refuse(path, "is a soft or external link; put the object itself there")
        if self.links < 0:
            refuse(path, "is one of more links than the file has room for")
        item = h5o.open(group, name)
        self.seen.add(h5o.get_info(item).addr)
        if isinstance(item, h5g.GroupID):
            self.group(path, item, depth + 1)
        elif isinstance(item, h5d.DatasetID):
            look_at_attributes(path, item)
            look_at_size(path, item, self.length)
            look_at_texts(path, item, self.length)
            self.datasets.append((path, item))

    def scales(self, path, dataset):
        """A reference may lead to an object that no link leads to, which was not looked at. One that leads nowhere,
        as in a copy of some datasets, ends the iteration, for the tools too."""
        found = []
        for dimension in range(dataset.rank):
            with contextlib.suppress(RuntimeError):
                h5ds.iterate(dataset, dimension, lambda scale: found.append(h5o.get_info(scale).addr))
        if not self.seen.issuperset(found):
            refuse(path, "has a dimension scale that no link leads to")


def open_guarded(path, **how):
    """An h5py.File for reading, or Unsafe."""
    if stat.S_ISFIFO(os.stat(path).st_mode):
        raise OSError("it must be a regular file")  # of a pipe HDF5 waits for a writer
    file = h5py.File(path, "r", **how)
    try:
        Walk(file)
    except BaseException:
        file.close()
        raise
    return file
