//! Loops in ACO's machine code.
//!
//! The text has a label `BB6:` before each block that is jumped to, an instruction a line with its words behind `;`,
//! and jumps such as `s_cbranch_execz BB32`. A jump to a label at or above it closes a loop. Of equal instructions in a
//! row the text has the first, and `(then repeated 3 times)`.

use std::collections::BTreeMap;

/// What is wrong with a line, counted from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Wrong {
    pub(crate) line: usize,
    pub(crate) what: String,
}

/// The loops of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Loops {
    /// How many, by their first block.
    pub(crate) count: u64,
    /// Names of the instructions of the longest loop without a loop inside.
    pub(crate) longest: Option<Vec<String>>,
    /// Instructions of the whole shader.
    pub(crate) instructions: u64,
}

/// A jump, and where it stands among the instructions.
struct Jump<'a> {
    at: usize,
    line: usize,
    target: &'a str,
}

/// Finds the loops.
pub(crate) fn loops(text: &str) -> Result<Loops, Wrong> {
    let mut labels = BTreeMap::new();
    let mut instructions = Vec::new();
    let mut jumps = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let code = content.split(';').next().unwrap_or_default().trim();
        let mut parts = code.split_whitespace();
        let Some(first) = parts.next() else { continue };
        if let Some(label) = first.strip_suffix(':') {
            if labels.insert(label, instructions.len()).is_some() {
                return Err(Wrong { line, what: format!("a second label `{label}`") });
            }
            continue;
        }
        if let Some(times) = repeats(code) {
            let Some(&last) = instructions.last().filter(|_| times <= MAXIMUM_REPEATS) else {
                return Err(Wrong { line, what: format!("nothing to repeat: `{code}`") });
            };
            instructions.extend(std::iter::repeat_n(last, times));
            continue;
        }
        if !is_name(first) {
            return Err(Wrong { line, what: format!("no instruction: `{code}`") });
        }
        if first == "s_branch" || first.starts_with("s_cbranch_") {
            let target = parts.next().unwrap_or_default();
            jumps.push(Jump { at: instructions.len(), line, target });
        }
        instructions.push(first);
    }
    if instructions.is_empty() {
        return Err(Wrong { line: 1, what: "no instructions".to_owned() });
    }
    // Several jumps back to one block are one loop, which ends at the last of them.
    let mut spans = BTreeMap::<usize, usize>::new();
    for Jump { at, line, target } in jumps {
        let Some(&start) = labels.get(target) else {
            return Err(Wrong { line, what: format!("a jump to `{target}`, which is no label") });
        };
        if start <= at {
            let end = spans.entry(start).or_default();
            *end = (*end).max(at + 1);
        }
    }
    let innermost = spans.iter().filter(|(start, end)| {
        !spans.iter().any(|(other, until)| {
            (*start, *end) != (other, until) && *start <= other && until <= *end
        })
    });
    // Of equally long ones the first.
    let longest = innermost.rev().max_by_key(|(start, end)| *end - *start);
    Ok(Loops {
        count: spans.len() as u64,
        instructions: instructions.len() as u64,
        longest: longest.map(|(start, end)| {
            instructions[*start..*end].iter().map(|name| (*name).to_owned()).collect()
        }),
    })
}

/// More would be a fault of the text: code of that size does not fit a shader.
const MAXIMUM_REPEATS: usize = 1 << 20;

/// How often the line says that the instruction above comes again.
fn repeats(code: &str) -> Option<usize> {
    code.strip_prefix("(then repeated ")?.strip_suffix(" times)")?.parse().ok()
}

/// Instructions are in lower case with an underscore, such as `v_add_f32_e32` and `image_load`.
fn is_name(word: &str) -> bool {
    word.contains('_')
        && word.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_'))
        && word.starts_with(|first: char| first.is_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_code_has_none() {
        let text = "BB0:\n\ts_mov_b32 s0, s3 ; be800303\n\ts_cbranch_execz BB1\nBB1:\n\ts_endpgm\n";
        assert_eq!(loops(text).unwrap(), Loops { count: 0, longest: None, instructions: 3 });
    }

    #[test]
    fn the_longest_innermost_loop_is_taken() {
        let text = "\
BB0:
\ts_mov_b32 s0, 0
BB1:
\ts_cmp_lt_u32 s0, 4
\ts_cbranch_scc0 BB9
BB2:
\tv_add_f32_e32 v0, v0, v1
\ts_cbranch_vccnz BB2
BB3:
\tv_mul_f32_e32 v0, v0, v1
\tv_rcp_f32_e32 v0, v0
\ts_cbranch_scc1 BB3
BB4:
\ts_branch BB1
BB9:
\ts_endpgm
";
        let found = loops(text).unwrap();
        assert_eq!(found.count, 3);
        assert_eq!(found.longest.unwrap(), ["v_mul_f32_e32", "v_rcp_f32_e32", "s_cbranch_scc1"]);
    }

    #[test]
    fn a_jump_out_and_two_jumps_back_are_one_loop() {
        // After RADV's text of a shading variant, shortened.
        let text = "\
BB6:
	s_cmp_ge_u32 s6, s7                                         ; bf090706
	s_cbranch_scc1 BB28                                         ; bf85017d
BB9:
	s_buffer_load_dwordx4 s[8:11], s[4:7], 0x0                  ; f4280202 fa000000
	s_cbranch_execz BB6                                         ; bf88fffa
	v_fmac_f32_e32 v17, v23, v21                                ; 56222b17
	s_add_u32 s6, s6, 1                                         ; 80068106
	s_branch BB6                                                ; bf82fe85
BB28:
	s_endpgm                                                    ; bf810000
";
        let found = loops(text).unwrap();
        assert_eq!((found.count, found.longest.unwrap().len()), (1, 7));
    }

    #[test]
    fn repeated_instructions_are_counted() {
        let text = "BB1:\n\ts_nop 0 ; bf800000\n\t(then repeated 3 times)\n\ts_branch BB1\n";
        assert_eq!(loops(text).unwrap().longest.unwrap().len(), 5);
    }

    #[test]
    fn what_is_not_understood_is_named() {
        let wrong = |text| loops(text).unwrap_err();
        assert_eq!(wrong("\ts_branch BB7\n").what, "a jump to `BB7`, which is no label");
        assert_eq!(wrong("BB0:\n\n\t(null)\n").line, 3);
        assert_eq!(wrong("BB0:\ns_endpgm\nBB0:\n").line, 3);
        assert_eq!(wrong("BB0:\n\t(then repeated 3 times)\n").line, 2);
        assert_eq!(wrong("").what, "no instructions");
    }
}
