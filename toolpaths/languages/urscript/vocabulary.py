"""The words of URScript, and what the reader does with each: for the pages and for tests."""

from __future__ import annotations

from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, Vocabulary
from toolpaths.languages.urscript.control import REMARKS
from toolpaths.languages.urscript.moves import PARAMETERS

_READ = "set_tcp set_payload set_target_payload def = global local return halt pose_trans"
VOCABULARY: dict[str, Vocabulary] = {
    "statements": Vocabulary(
        {
            HONOURED: [*PARAMETERS, *_READ.split(" ")],
            REMARK: [*REMARKS, "while", "if", "thread", "run", "kill", "join", "#", "$"],
            REFUSED: """servoc servoj speedj speedl force_mode conveyor_pulse_decode track_conveyor_linear
                track_conveyor_circular freedrive_mode teach_mode path_offset_set get_target_tcp_pose
                get_actual_tcp_pose""",
        }
    )
}
