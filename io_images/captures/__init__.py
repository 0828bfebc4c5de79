"""Captures of a network, as Wireshark and tcpdump write them: packets, TCP segments, streams of bytes.

    file --packets.py--> packets --segments.py--> TCP segments --streams.py--> bytes in order, by connection

Files may be hostile: every length is checked before it is used, and what waits is bounded.
"""
