"""The limits of silence of a cell."""
import dataclasses

from duration import parse_duration


@dataclasses.dataclass(frozen=True)
class Limits:
    """Defaults: those of deploy/cells/three_hosts.yaml."""
    silence: float = 0.25  # [s] of a node
    lease: float = 1.0     # [s] of a host

    @staticmethod
    def of(document):
        """The limits of a cell file, or the defaults (docs/reference/cell-file.md)."""
        supervision = document.get("supervision", {})
        return Limits(parse_duration(supervision.get("heartbeat_deadline", "20ms")),
                      parse_duration(supervision.get("host_lease", "100ms")))
