"""Recordings as earlier versions wrote them: with the old names of events."""

import os
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from rocs_bt.record.renamed_events import RENAMED_EVENTS

OLD = {new: old for old, new in RENAMED_EVENTS.items()}


def age(path: Path) -> set[str]:
    """Rewrite a recording with the old names; returns the names of the events in it that were renamed since."""
    found, part = set(), path.with_suffix(".part")
    with path.open("rb") as stream:
        reader = make_reader(stream)
        writer = Writer(str(part), compression=CompressionType.LZ4)
        writer.start(reader.get_header().profile, reader.get_header().library)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        schemas, channels = {}, {}
        attachments = list(reader.iter_attachments())
        for number, each in enumerate(attachments):
            if number == 0:  # the header is before the events, the summary after them
                writer.add_attachment(each.create_time, each.log_time, each.name, each.media_type, each.data)
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            new = schema.name.removeprefix("rocs_bt.")
            old = OLD.get(new, new)
            if schema.id not in schemas:
                named = schema.name.replace(new, old) if new in OLD else schema.name
                schemas[schema.id] = writer.register_schema(named, schema.encoding, schema.data)
            if channel.id not in channels:
                topic = channel.topic.replace(new, old) if new in OLD else channel.topic
                channels[channel.id] = writer.register_channel(topic, "json", schemas[schema.id])
            data = message.data
            if new in OLD:
                found.add(old)
                tag = f'{{"event":"{new}"'.encode()
                assert data.startswith(tag)
                data = f'{{"event":"{old}"'.encode() + data.removeprefix(tag)
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time, message.sequence)
        for each in attachments[1:]:
            writer.add_attachment(each.create_time, each.log_time, each.name, each.media_type, each.data)
        writer.finish()
    os.replace(part, path)
    return found
