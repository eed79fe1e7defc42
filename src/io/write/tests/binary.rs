use super::*;

/// The head of a `.vtu` file, and the arrays as raw bytes by name. Of arrays with the same name, the last one is returned.
pub(super) fn vtu_arrays(bytes: &[u8]) -> (String, HashMap<String, Vec<u8>>) {
    let marker = b"encoding=\"raw\">\n   _";
    let start = bytes.windows(marker.len()).position(|w| w == marker).unwrap() + marker.len();
    let head = String::from_utf8(bytes[..start].to_vec()).unwrap();
    let attribute = |line: &str, name: &str| {
        let value = line.split(&format!(" {name}=\"")).nth(1)?;
        value.split('"').next().map(str::to_owned)
    };
    let mut arrays = HashMap::new();
    let mut end = 0;
    let declared = head.lines().filter(|line| line.contains("<DataArray"));
    let mut declared: Vec<(usize, &str)> =
        declared.map(|line| (attribute(line, "offset").unwrap().parse().unwrap(), line)).collect();
    // The data may be in another order than their declarations.
    declared.sort_unstable();
    for (offset, line) in declared {
        assert_eq!(offset, end);
        let at = start + offset;
        let size = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
        end = offset + 8 + size;
        let name = attribute(line, "Name").unwrap();
        arrays.insert(name, bytes[at + 8..at + 8 + size].to_vec());
    }
    assert_eq!(&bytes[start + end..], b"\n  </AppendedData>\n</VTKFile>\n");
    (head, arrays)
}

pub(super) fn words(bytes: &[u8]) -> Vec<u64> {
    bytes.chunks_exact(8).map(|w| u64::from_le_bytes(w.try_into().unwrap())).collect()
}

#[test]
fn vtu_holds_the_mesh() {
    for (sample, kind) in [(awkward(kuhn(2)), 10), (awkward(squares(3)), 5)] {
        let (head, arrays) = vtu_arrays(&one("m.vtu", &sample));
        let (d, n, m) = (sample.dimension, sample.view().point_count(), sample.view().cell_count());
        assert!(head.contains("version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\""));
        assert!(head.contains(&format!("NumberOfPoints=\"{n}\" NumberOfCells=\"{m}\"")));
        assert!(head.contains("PointData GlobalIds=\"GlobalPointIds\""));
        assert!(head.contains("CellData GlobalIds=\"GlobalCellIds\""));
        assert_eq!(words(&arrays["connectivity"]), sample.cells);
        let ends: Vec<u64> = (1..=m as u64).map(|i| i * (d as u64 + 1)).collect();
        assert_eq!(words(&arrays["offsets"]), ends);
        assert_eq!(arrays["types"], vec![kind; m]);
        assert_eq!(words(&arrays["GlobalPointIds"]), (0..n as u64).collect::<Vec<_>>());
        assert_eq!(words(&arrays["GlobalCellIds"]), (0..m as u64).collect::<Vec<_>>());
        assert_eq!(arrays["radius_edge_ratio"].len(), 8 * m);
        for (row, point) in words(&arrays["Points"]).chunks(3).zip(sample.coordinates.chunks(d)) {
            let mut expected = point.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            expected.resize(3, 0);
            assert_eq!(row, expected);
        }
        assert!(!arrays.contains_key("owner") && !arrays.contains_key("home_leaf"));
    }
}

#[test]
fn vtu_holds_owners_where_asked_for() {
    let sample = kuhn(1);
    let options = WriteOptions { with_owner: true, ..WriteOptions::default() };
    let (_, arrays) = vtu_arrays(&written("m.vtu", &sample, &options)["m.vtu"]);
    let owner: Vec<u8> = sample.owner.iter().flat_map(|o| o.to_le_bytes()).collect();
    assert_eq!(arrays["owner"], owner);
    assert_eq!(words(&arrays["home_leaf"]), sample.owning_leaf);
    let ratios = words(&arrays["radius_edge_ratio"]);
    // The diagonal of the cube is a diameter of the circumsphere of a Kuhn tetrahedron.
    let expected = 0.75f64.sqrt();
    assert!(ratios.iter().all(|r| (f64::from_bits(*r) - expected).abs() < 1e-15));
}
