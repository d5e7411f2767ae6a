//! SPIR-V made legible for the validation layer.

/// `OpAccessChain` and `OpInBoundsAccessChain`.
const CHAINS: [u32; 2] = [65, 66];
/// Words before the first instruction.
const HEADER: usize = 5;

/// The same module with every chain of access chains folded into one that starts at a variable.
///
/// naga reaches a buffer's elements in two steps, and older validation layers (1.3.239 among them) follow only one: they
/// take such a store for no store at all, and report no hazard. An access chain means the same in one step as in two.
pub(crate) fn fold_access_chains(words: &[u32]) -> Vec<u32> {
    // Result of a chain -> its base and indices, as positions in the output.
    let mut chains = std::collections::HashMap::new();
    let mut folded = words[..HEADER.min(words.len())].to_vec();
    let mut rest = &words[folded.len()..];
    while let Some(&first) = rest.first() {
        let length = (first >> 16) as usize;
        if length == 0 || length > rest.len() {
            // Not SPIR-V; whoever reads it next says so.
            folded.extend_from_slice(rest);
            break;
        }
        let (instruction, after) = rest.split_at(length);
        rest = after;
        let start = folded.len();
        match instruction {
            [_, kind, result, base, indices @ ..] if CHAINS.contains(&(first & 0xffff)) => {
                folded.extend([first, *kind, *result]);
                match chains.get(base).cloned() {
                    Some(inner) => folded.extend_from_within(inner),
                    None => folded.push(*base),
                }
                folded.extend_from_slice(indices);
                let words = (folded.len() - start) as u32;
                folded[start] = words << 16 | first & 0xffff;
                chains.insert(*result, start + 3..folded.len());
            }
            _ => folded.extend_from_slice(instruction),
        }
    }
    folded
}

#[cfg(test)]
mod tests {
    use super::*;

    fn module(instructions: &[&[u32]]) -> Vec<u32> {
        let mut words = vec![0x0723_0203, 0x0001_0600, 0, 100, 0];
        for instruction in instructions {
            words.push((instruction.len() as u32) << 16 | instruction[0]);
            words.extend_from_slice(&instruction[1..]);
        }
        words
    }

    #[test]
    fn chains_of_chains_start_at_the_variable() {
        // %21 = chain %20 [%1]; %22 = chain %21 [%2, %3]; store %22 %9; %23 = chain %22 [%4]
        let nested = module(&[
            &[65, 10, 21, 20, 1],
            &[66, 11, 22, 21, 2, 3],
            &[62, 22, 9],
            &[65, 12, 23, 22, 4],
        ]);
        let flat = module(&[
            &[65, 10, 21, 20, 1],
            &[66, 11, 22, 20, 1, 2, 3],
            &[62, 22, 9],
            &[65, 12, 23, 20, 1, 2, 3, 4],
        ]);
        assert_eq!(fold_access_chains(&nested), flat);
        assert_eq!(fold_access_chains(&flat), flat);
    }

    #[test]
    fn what_is_not_spirv_stays() {
        for words in [
            &[][..],
            &[1, 2, 3],
            &[1, 2, 3, 4, 5, 0, 7],
            &[1, 2, 3, 4, 5, 9 << 16 | 65, 7],
        ] {
            assert_eq!(fold_access_chains(words), words);
        }
    }
}
