"""Network captures from Wireshark and tcpdump: packets, TCP segments, and streams of bytes.

    file --packets.py--> packets --segments.py--> TCP segments --streams.py--> bytes in order, by connection

Files may be hostile: every length is checked before use, and the amount of buffered data is limited.
"""
